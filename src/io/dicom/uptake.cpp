// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/uptake.h"

#include <chrono>
#include <cmath>
#include <optional>

#include "core/number_text.h"
#include "io/dicom/dicom_requests.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

constexpr double kSecondsPerDay = 86400;

/// Text without blanks at its ends and the zero bytes that pad it.
std::string trimmed(const std::string& text) {
  const char* const padding = " \t\0";
  const std::string all(padding, 3);
  const std::size_t first = text.find_first_not_of(all);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(all) - first + 1);
}

std::optional<int> digits_at(const std::string& text, std::size_t at, std::size_t count) {
  if (text.size() < at + count) return std::nullopt;
  int value = 0;
  for (std::size_t n = at; n < at + count; ++n) {
    if (text[n] < '0' || text[n] > '9') return std::nullopt;
    value = 10 * value + (text[n] - '0');
  }
  return value;
}

/// Days of a date (DA, or the beginning of DT) since 1970; nullopt for another text.
std::optional<double> days_of(const std::string& date) {
  const auto year = digits_at(date, 0, 4), month = digits_at(date, 4, 2), day = digits_at(date, 6, 2);
  if (!year || !month || !day) return std::nullopt;
  const std::chrono::year_month_day all{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                                        std::chrono::day(static_cast<unsigned>(*day))};
  if (!all.ok()) return std::nullopt;
  return static_cast<double>(std::chrono::sys_days(all).time_since_epoch().count());
}

/// Seconds of a time (TM: hhmmss.ffffff, of which minutes and seconds can be missing); nullopt for another text.
std::optional<double> seconds_of(const std::string& time) {
  const std::optional<int> hours = digits_at(time, 0, 2), minutes = digits_at(time, 2, 2),
                           whole = digits_at(time, 4, 2);
  if (!hours || *hours > 23 || minutes.value_or(0) > 59 || whole.value_or(0) > 60) return std::nullopt;
  double seconds = 3600.0 * *hours + 60.0 * minutes.value_or(0) + whole.value_or(0), digit = 0.1;
  if (whole && time.size() > 7 && time[6] == '.')
    for (std::size_t n = 7; n < time.size() && time[n] >= '0' && time[n] <= '9'; ++n, digit /= 10)
      seconds += digit * (time[n] - '0');
  return seconds;
}

std::optional<double> number_above_0(const std::string& text) {
  const std::optional<double> number = parse_number(text);
  return number && std::isfinite(*number) && *number > 0 ? number : std::nullopt;
}

UptakeScale refuse(const std::string& why) { return {0, why}; }
UptakeScale refuse_missing(const std::string& what, const std::string& text) {
  return refuse(what + (text.empty() ? " is missing" : " is '" + text + "', which is not valid"));
}

/// Seconds from the injection to the time to which the image is corrected, or the refusal.
UptakeScale decay_seconds(const PetAttributes& pet, double& seconds) {
  if (pet.decay_correction == "ADMIN") {
    seconds = 0;
    return {};
  }
  if (pet.decay_correction != "START") return refuse_missing("Decay Correction (0054,1102)", pet.decay_correction);
  const auto date = days_of(pet.series_date), time = seconds_of(pet.series_time);
  if (!date) return refuse_missing("Series Date (0008,0021)", pet.series_date);
  if (!time) return refuse_missing("Series Time (0008,0031)", pet.series_time);
  const double scan = *date * kSecondsPerDay + *time;
  const auto acquired_date = days_of(pet.acquisition_date), acquired_time = seconds_of(pet.acquisition_time);
  if (!acquired_date) return refuse_missing("Acquisition Date (0008,0022)", pet.acquisition_date);
  if (!acquired_time) return refuse_missing("Acquisition Time (0008,0032)", pet.acquisition_time);
  // Postprocessing replaces the time of the series, to whose start the decay was corrected.
  if (scan > *acquired_date * kSecondsPerDay + *acquired_time)
    return refuse(
        "Series Time (0008,0031) is after Acquisition Time (0008,0032), so the time of decay correction is unknown");
  if (const auto start_date = days_of(pet.start_date_time)) {
    const auto start_time = seconds_of(pet.start_date_time.substr(8));
    if (!start_time) return refuse_missing("Radiopharmaceutical Start DateTime (0018,1078)", pet.start_date_time);
    seconds = scan - *start_date * kSecondsPerDay - *start_time;
  } else {
    const auto start_time = seconds_of(pet.start_time);
    if (!start_time) return refuse_missing("Radiopharmaceutical Start Time (0018,1072)", pet.start_time);
    seconds = *time - *start_time;
    if (seconds < 0) seconds += kSecondsPerDay;  // injected before midnight
  }
  if (seconds < 0) return refuse("Radiopharmaceutical Start DateTime (0018,1078) is after Series Time (0008,0031)");
  return {};
}

/// Whether values in g/ml are uptake by body weight: the default of SUV Type (PS3.3 C.8.9.1).
bool is_body_weight(const PetAttributes& pet) { return pet.suv_type.empty() || pet.suv_type == "BW"; }

}  // namespace

UptakeScale uptake_scale(const PetAttributes& pet) {
  if (pet.units == "GML") {
    if (!is_body_weight(pet)) return refuse("SUV Type (0054,1006) is '" + pet.suv_type + "', not BW");
    return {1, ""};
  }
  if (pet.units == "CNTS") {
    if (const auto factor = number_above_0(pet.philips_factor)) return {*factor, ""};
    const auto activity = number_above_0(pet.philips_activity);
    if (!activity) return refuse_missing("SUV Scale Factor (7053,1000)", pet.philips_factor);
    PetAttributes calibrated = pet;
    calibrated.units = "BQML";
    UptakeScale scale = uptake_scale(calibrated);
    scale.factor *= *activity;
    return scale;
  }
  if (pet.units != "BQML") return refuse_missing("Units (0054,1001)", pet.units);
  for (const char* const correction : {"ATTN", "DECY"})
    if (pet.corrected_image.find(correction) == std::string::npos)
      return refuse(std::string("Corrected Image (0028,0051) does not contain ") + correction);
  const auto dose = number_above_0(pet.total_dose_bq), half_life = number_above_0(pet.half_life_s),
             weight = number_above_0(pet.weight_kg);
  if (!weight) return refuse_missing("Patient's Weight (0010,1030)", pet.weight_kg);
  if (!dose) return refuse_missing("Radionuclide Total Dose (0018,1074)", pet.total_dose_bq);
  double seconds = 0;
  if (UptakeScale refusal = decay_seconds(pet, seconds); !refusal.refusal.empty()) return refusal;
  if (seconds > 0 && !half_life) return refuse_missing("Radionuclide Half Life (0018,1075)", pet.half_life_s);
  const double decayed = *dose * (seconds > 0 ? std::exp2(-seconds / *half_life) : 1);
  constexpr double kGramsPerKilogram = 1000;
  return {*weight * kGramsPerKilogram / decayed, ""};
}

std::string uptake_warning(const std::filesystem::path& path, const UptakeScale& uptake) {
  if (uptake.refusal.empty()) return "";
  return "uptake values (SUV) of " + quoted(path) + " are not available: " + uptake.refusal +
         "; stored values are shown";
}

std::string unit_of_pet(const PetAttributes& pet) {
  if (pet.units == "GML") return is_body_weight(pet) ? "g/ml" : "g/ml (" + pet.suv_type + ")";
  return pet.units == "BQML" ? "Bq/ml" : pet.units == "CNTS" ? "counts" : "";
}

PetAttributes read_pet_attributes(const std::filesystem::path& file) {
  PetAttributes pet;
  const std::pair<DicomTag, std::string*> members[] = {{{0x0054, 0x1001}, &pet.units},
                                                       {{0x0054, 0x1006}, &pet.suv_type},
                                                       {{0x0028, 0x0051}, &pet.corrected_image},
                                                       {{0x0054, 0x1102}, &pet.decay_correction},
                                                       {{0x0008, 0x0021}, &pet.series_date},
                                                       {{0x0008, 0x0031}, &pet.series_time},
                                                       {{0x0008, 0x0022}, &pet.acquisition_date},
                                                       {{0x0008, 0x0032}, &pet.acquisition_time},
                                                       {{0x0018, 0x1072}, &pet.start_time},
                                                       {{0x0018, 0x1078}, &pet.start_date_time},
                                                       {{0x0018, 0x1074}, &pet.total_dose_bq},
                                                       {{0x0018, 0x1075}, &pet.half_life_s},
                                                       {{0x0010, 0x1030}, &pet.weight_kg},
                                                       {{0x7053, 0x1000}, &pet.philips_factor},
                                                       {{0x7053, 0x1009}, &pet.philips_activity}};
  std::vector<DicomTag> tags;
  for (const auto& [tag, member] : members) tags.push_back(tag);
  try {
    const std::vector<std::string> values = read_dicom_values(file, tags);
    for (std::size_t n = 0; n < values.size(); ++n) *members[n].second = trimmed(values[n]);
  } catch (const WorkerUnavailable&) {
    throw;
  } catch (const std::exception&) {  // unreadable files have no attributes
  }
  return pet;
}

}  // namespace simplexseg
