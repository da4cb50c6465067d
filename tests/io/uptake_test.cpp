// SPDX-License-Identifier: Apache-2.0
// Standardized uptake values of PET, against published values and values computed by hand, and refusals that name the
// attribute.
#include "io/dicom/uptake.h"

#include <functional>

#include "dicom_files.h"
#include "io/scene/load_input.h"
#include "io/volume/volume_checksum.h"
#include "io/volume/volume_io.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using test::DicomData;

/// FDG: 374 MBq injected at 08:30:45, as in the header shown by the documentation of cornerstonejs/calculate-suv.
PetAttributes fdg() {
  PetAttributes pet;
  pet.units = "BQML", pet.corrected_image = "NORM\\DTIM\\ATTN\\SCAT\\DECY\\RAN", pet.decay_correction = "START";
  pet.series_date = "20140618", pet.series_time = "093031.200000";
  pet.acquisition_date = "20140618", pet.acquisition_time = "093031.200000";
  pet.start_time = "083045.000000", pet.start_date_time = "20140618083045.000000";
  pet.total_dose_bq = "374000000", pet.half_life_s = "6586.2", pet.weight_kg = "70";
  return pet;
}

/// Expects a factor with a relative error of 1e-4.
void expect_factor(const PetAttributes& pet, double factor) {
  const UptakeScale scale = uptake_scale(pet);
  EXPECT_EQ(scale.refusal, "");
  EXPECT_NEAR(scale.factor, factor, 1e-4 * factor);
}

TEST(Uptake, OfADoseThatDecaysUntilTheScan) {
  // 09:30:31.2 - 08:30:45 = 3586.2 s = 0.544502 times the half life. 2^-0.544502 = exp(-0.377420) = 0.685628.
  // 374e6 Bq * 0.685628 = 256.4249e6 Bq. 70000 g / 256.4249e6 Bq = 2.729844e-4 g/ml per Bq/ml: 5000 Bq/ml is
  // SUV 1.36492.
  expect_factor(fdg(), 2.729844e-4);
  EXPECT_NEAR(5000 * uptake_scale(fdg()).factor, 1.364922, 1e-4);
}

TEST(Uptake, OfADoseAtTheTimeOfInjection) {
  // The unit test of cornerstonejs/calculate-suv: 100 Bq, 100 kg, corrected to the administration: 100000 / 100 = 1000.
  PetAttributes pet = fdg();
  pet.decay_correction = "ADMIN", pet.total_dose_bq = "100", pet.weight_kg = "100", pet.half_life_s = "10";
  expect_factor(pet, 1000);
  // Definition of SUV: 370 MBq spread evenly through 70 kg, 5285.714 Bq/ml, is SUV 1.
  pet.total_dose_bq = "3.7e8", pet.weight_kg = "70";
  EXPECT_NEAR(5285.714 * uptake_scale(pet).factor, 1, 1e-4);
}

TEST(Uptake, OfAnInjectionBeforeMidnightWithAShortHalfLife) {
  // Carbon-11, 1223.4 s. Injected at 23:50:00, scan at 00:10:23.4 the next day: 1223.4 s, one half life.
  // 600e6 Bq / 2 = 300e6 Bq. 60000 g / 300e6 Bq = 2e-4 g/ml per Bq/ml.
  PetAttributes pet = fdg();
  pet.start_date_time.clear(), pet.start_time = "235000", pet.series_time = pet.acquisition_time = "001023.4";
  pet.half_life_s = "1223.4", pet.total_dose_bq = "600000000", pet.weight_kg = "60";
  expect_factor(pet, 2e-4);
  pet.start_date_time = "20140617235000.00+0200";  // the same with its date
  expect_factor(pet, 2e-4);
}

TEST(Uptake, OfThePublishedSeriesQinHeadneck010366) {
  // Series of The Cancer Imaging Archive, computed by SUVFactorCalculator of the PET DICOM extension of 3D Slicer,
  // which its author A. Fedorov published with its input (discourse.slicer.org, 19 July 2019): 63.2 kg, 3.8591e8 Bq,
  // injection at 39180 s, series at 44254.7 s of the day, fluorine-18; dose after decay 226226 kBq, SUVbw factor
  // 0.000279366.
  PetAttributes pet = fdg();
  pet.start_date_time.clear(), pet.start_time = "105300", pet.series_time = pet.acquisition_time = "121734.7";
  pet.series_date = pet.acquisition_date = "19860303";
  pet.total_dose_bq = "3.8591e8", pet.weight_kg = "63.2";
  expect_factor(pet, 0.000279366);
  EXPECT_NEAR(63.2e3 / uptake_scale(pet).factor / 1e3, 226226, 226226 * 1e-4);
}

TEST(Uptake, OfThePublishedSeriesQinBreast010001) {
  // Series of The Cancer Imaging Archive with the expected factor of a public test (panorama, tests of suv_bw_factor):
  // 77 kg, 432151424 Bq, half life 6588 s, injection at 15:48:00, series at 17:23:00: 3.2457e-4. By hand:
  // 2^-(5700/6588) = 0.548967; 77000 / (432151424 * 0.548967) = 3.245703e-4.
  PetAttributes pet = fdg();
  pet.start_date_time.clear(), pet.start_time = "154800.00", pet.series_time = pet.acquisition_time = "172300";
  pet.series_date = pet.acquisition_date = "19910901";
  pet.total_dose_bq = "432151424", pet.half_life_s = "6588", pet.weight_kg = "77";
  expect_factor(pet, 3.2457e-4);
}

TEST(Uptake, OfThePublishedTestsOfCalculateSuv) {
  // Tests of cornerstonejs/calculate-suv (test/calculateSUVScalingFactors.test.ts): corrected to the administration,
  // 100 Bq. 75 kg give 750; counts of Philips have the SUV factor 0.000551, or, where this is 0, 1.602563 Bq/ml per
  // count and 100 kg, which give 1602.563.
  PetAttributes pet = fdg();
  pet.decay_correction = "ADMIN", pet.total_dose_bq = "100", pet.weight_kg = "75", pet.half_life_s = "10";
  expect_factor(pet, 750);
  pet.units = "CNTS", pet.weight_kg = "100", pet.philips_factor = "0.000551", pet.philips_activity = "1.602563";
  expect_factor(pet, 0.000551);
  pet.philips_factor = "0";
  expect_factor(pet, 1602.5629999999999);
  pet.weight_kg.clear();
  EXPECT_NE(uptake_scale(pet).refusal.find("(0010,1030) is missing"), std::string::npos);
  EXPECT_EQ(uptake_scale(pet).factor, 0);
  pet.philips_activity.clear();
  EXPECT_NE(uptake_scale(pet).refusal.find("(7053,1000)"), std::string::npos);
}

TEST(Uptake, OfImagesThatContainItAlready) {
  PetAttributes pet;
  pet.units = "GML";
  expect_factor(pet, 1);
  pet.suv_type = "BW";
  expect_factor(pet, 1);
  pet.suv_type = "LBM";
  EXPECT_NE(uptake_scale(pet).refusal.find("(0054,1006)"), std::string::npos);
  EXPECT_EQ(unit_of_pet(pet), "g/ml (LBM)");
  pet.suv_type = "BW";
  EXPECT_EQ(unit_of_pet(pet), "g/ml");
  pet = {};
  pet.units = "CNTS", pet.philips_factor = "0.000551";
  expect_factor(pet, 5.51e-4);
}

TEST(Uptake, AMissingAttributeIsNamedWithItsTag) {
  const std::pair<std::string PetAttributes::*, const char*> needed[] = {
      {&PetAttributes::units, "Units (0054,1001) is missing"},
      {&PetAttributes::corrected_image, "Corrected Image (0028,0051)"},
      {&PetAttributes::decay_correction, "Decay Correction (0054,1102) is missing"},
      {&PetAttributes::series_date, "Series Date (0008,0021) is missing"},
      {&PetAttributes::series_time, "Series Time (0008,0031) is missing"},
      {&PetAttributes::acquisition_date, "Acquisition Date (0008,0022) is missing"},
      {&PetAttributes::acquisition_time, "Acquisition Time (0008,0032) is missing"},
      {&PetAttributes::total_dose_bq, "Radionuclide Total Dose (0018,1074) is missing"},
      {&PetAttributes::half_life_s, "Radionuclide Half Life (0018,1075) is missing"},
      {&PetAttributes::weight_kg, "Patient's Weight (0010,1030) is missing"}};
  for (const auto& [member, text] : needed) {
    PetAttributes pet = fdg();
    (pet.*member).clear();
    const UptakeScale scale = uptake_scale(pet);
    EXPECT_EQ(scale.factor, 0) << text;
    EXPECT_NE(scale.refusal.find(text), std::string::npos) << scale.refusal;
    EXPECT_EQ(scale.refusal.find('\n'), std::string::npos);
  }
  PetAttributes pet = fdg();
  pet.start_time.clear(), pet.start_date_time.clear();
  EXPECT_NE(uptake_scale(pet).refusal.find("(0018,1072) is missing"), std::string::npos);
}

TEST(Uptake, ValuesThatCannotBeRightAreRefused) {
  const auto refusal = [](const std::function<void(PetAttributes&)>& change) {
    PetAttributes pet = fdg();
    change(pet);
    return uptake_scale(pet).refusal;
  };
  EXPECT_NE(refusal([](auto& pet) { pet.weight_kg = "0"; }).find("'0'"), std::string::npos);
  EXPECT_NE(refusal([](auto& pet) { pet.total_dose_bq = "3,7"; }).find("'3,7'"), std::string::npos);
  EXPECT_NE(refusal([](auto& pet) { pet.decay_correction = "NONE"; }).find("'NONE'"), std::string::npos);
  EXPECT_NE(refusal([](auto& pet) { pet.units = "PROPCPS"; }).find("'PROPCPS'"), std::string::npos);
  EXPECT_NE(refusal([](auto& pet) { pet.series_time = "2561"; }).find("'2561'"), std::string::npos);
  EXPECT_NE(refusal([](auto& pet) { pet.series_date = "20141318"; }).find("(0008,0021)"), std::string::npos);
  // A series that was processed after the scan has lost the time to which its decay is corrected.
  EXPECT_NE(refusal([](auto& pet) { pet.series_time = "101500"; }).find("after Acquisition Time"), std::string::npos);
  EXPECT_NE(refusal([](auto& pet) { pet.start_date_time = "20140618100000"; }).find("(0018,1078)"), std::string::npos);
}

class UptakeFile : public test::FolderTest {
 protected:
  /// Writes one slice of PET with constant pixels.
  std::filesystem::path write_pet(bool with_weight) const {
    DicomData item;
    item.text(0x0018, 0x1072, "TM", "083045").text(0x0018, 0x1074, "DS", "374000000");
    item.text(0x0018, 0x1075, "DS", "6586.2");
    DicomData data;
    const std::string sop_class = "1.2.840.10008.5.1.4.1.1.128";
    data.text(0x0008, 0x0016, "UI", sop_class).text(0x0008, 0x0018, "UI", "1.2.3.4");
    data.text(0x0008, 0x0021, "DA", "20140618").text(0x0008, 0x0022, "DA", "20140618");
    data.text(0x0008, 0x0031, "TM", "093031.2").text(0x0008, 0x0032, "TM", "093031.2");
    data.text(0x0008, 0x0060, "CS", "PT");
    if (with_weight) data.text(0x0010, 0x1030, "DS", "70");
    data.text(0x0020, 0x000e, "UI", "1.2.3").numbers(0x0020, 0x0032, {0, 0, 0});
    data.numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
    data.us(0x0028, 0x0002, 1).text(0x0028, 0x0004, "CS", "MONOCHROME2").us(0x0028, 0x0010, 2).us(0x0028, 0x0011, 2);
    data.numbers(0x0028, 0x0030, {4, 4}).text(0x0028, 0x0051, "CS", "ATTN\\DECY");
    data.us(0x0028, 0x0100, 16).us(0x0028, 0x0101, 16).us(0x0028, 0x0102, 15).us(0x0028, 0x0103, 0);
    data.numbers(0x0028, 0x1052, {0}).numbers(0x0028, 0x1053, {2.5});
    data.sequence(0x0054, 0x0016, {item.bytes}).text(0x0054, 0x1001, "CS", "BQML");
    data.text(0x0054, 0x1102, "CS", "START");
    data.raw(
        0x7fe0, 0x0010, "OW",
        test::bytes_of_numbers<std::uint16_t, std::uint16_t, std::uint16_t, std::uint16_t>(2000, 2000, 2000, 2000));
    const std::filesystem::path path = folder / "pet.dcm";
    std::ofstream(path, std::ios::binary) << test::dicom_file(data.bytes, sop_class);
    return path;
  }
};

TEST_F(UptakeFile, AttributesAreReadFromTheSequenceOfTheTracer) {
  const LoadedVolume loaded = load_volume(write_pet(true));
  EXPECT_EQ(loaded.intensity_unit, "Bq/ml");
  EXPECT_EQ(loaded.uptake.refusal, "");
  // 2000 * 2.5 = 5000 Bq/ml, as in the first test.
  EXPECT_NEAR(loaded.volume.value(0, 0, 0) * loaded.uptake.factor, 1.364922, 1e-4);
}

TEST_F(UptakeFile, AFileWithoutAWeightIsReadWithTheReason) {
  const LoadedVolume loaded = load_volume(write_pet(false));
  EXPECT_EQ(loaded.volume.value(0, 0, 0), 5000);
  EXPECT_EQ(loaded.uptake.factor, 0);
  EXPECT_NE(loaded.uptake.refusal.find("(0010,1030)"), std::string::npos);
}

TEST_F(UptakeFile, AnOpenedSeriesHasUptakeValuesOrOneWarning) {
  const LoadedInput input = load_input(write_pet(true));
  for (const std::string& warning : input.warnings) EXPECT_EQ(warning.find("SUV"), std::string::npos) << warning;
  EXPECT_NEAR(input.volume.value(0, 0, 0), 1.364922, 1e-4);
  const Preprocessing& preprocessing = input.scene.volume_preprocessing;
  ASSERT_EQ(preprocessing.filters.size(), 1u);
  EXPECT_EQ(preprocessing.filters[0].kind, FilterKind::Uptake);
  EXPECT_EQ(unit_after(preprocessing.filters, input.intensity_unit), "SUV");
  EXPECT_EQ(preprocessing.checksum, checksum_of(input.volume));
  ASSERT_FALSE(input.volumes.empty());  // stored values, for undo
  EXPECT_EQ(input.volumes[0].volume.value(0, 0, 0), 5000);
  // The scene keeps the factor: reading it again needs no attribute.
  write_scene(folder / "scene.json", input.scene);
  write_pet(false);
  EXPECT_EQ(load_input(folder / "scene.json").volume.value(1, 1, 0), input.volume.value(1, 1, 0));
  const LoadedInput without = load_input(folder / "pet.dcm");
  EXPECT_EQ(without.volume.value(0, 0, 0), 5000);
  EXPECT_EQ(unit_after(without.scene.volume_preprocessing.filters, without.intensity_unit), "Bq/ml");
  ASSERT_EQ(without.warnings.size(), 2u);  // and that it is a single slice
  EXPECT_NE(without.warnings[1].find("Patient's Weight (0010,1030) is missing"), std::string::npos);
  EXPECT_EQ(without.warnings[1].find('\n'), std::string::npos);
}

}  // namespace
}  // namespace simplexseg
