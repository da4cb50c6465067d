// SPDX-License-Identifier: Apache-2.0
// Standardized uptake values of PET, normalised by body weight (SUVbw), from the attributes of a series. Source: the
// vendor-neutral pseudo-code of the Quantitative Imaging Biomarkers Alliance (QIBA) of the RSNA.
#pragma once
#include <filesystem>
#include <string>

namespace simplexseg {

/// Attributes of a PET image as texts of DICOM; empty when missing.
struct PetAttributes {
  std::string units;                              ///< "BQML", "GML" or "CNTS"
  std::string suv_type;                           ///< of GML: "BW" or empty
  std::string corrected_image, decay_correction;  ///< "NORM\\ATTN\\DECY"; "START", "ADMIN" or "NONE"
  std::string series_date, series_time;           ///< DA and TM
  std::string acquisition_date, acquisition_time;
  std::string start_time, start_date_time;  ///< of the injection, TM and DT; one of them suffices
  std::string total_dose_bq, half_life_s;   ///< injected dose at the time of injection
  std::string weight_kg;
  std::string philips_factor;    ///< private SUV Scale Factor (7053,1000) for CNTS
  std::string philips_activity;  ///< private Activity Concentration Scale Factor (7053,1009) for CNTS, Bq/ml
};

/// Factor from voxel values to SUVbw, or the reason why there is none.
struct UptakeScale {
  double factor = 0;    ///< g/ml per unit of the voxels; 0: not available
  std::string refusal;  ///< one clause that names the attribute with its tag; empty with a factor
};

/// SUVbw factor: for BQML, weight in g over the dose that has decayed until the time to which the image is corrected
/// (START: series date and time; ADMIN: the injection); for GML 1; for CNTS that of Philips, or else by its factor to
/// Bq/ml as for BQML.
UptakeScale uptake_scale(const PetAttributes& pet);

/// Reads the attributes of a file; all are empty if it cannot be read. Throws WorkerUnavailable.
PetAttributes read_pet_attributes(const std::filesystem::path& file);

/// Warning of one line that stored values are shown, and why; "" with a factor, and for images without refusal.
std::string uptake_warning(const std::filesystem::path& path, const UptakeScale& uptake);

/// Unit of the voxel values of Units (0054,1001): "Bq/ml", "counts", "g/ml" for uptake by body weight, and "g/ml (LBM)"
/// and the like for the other SUV Types (0054,1006); "" for others.
std::string unit_of_pet(const PetAttributes& pet);

}  // namespace simplexseg
