// SPDX-License-Identifier: Apache-2.0
#include "io/dicom_write/dicom_source.h"

#include <ctime>
#include <map>
#include <set>

#include "io/dicom/dicom_requests.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_texts.h"
#include "io/platform/files.h"
#include "io/source/volume_source.h"
#include "io/volume/volume_io.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr DicomTag kCharacterSet{0x0008, 0x0005};
constexpr DicomTag kFrameOfReference{0x0020, 0x0052};
constexpr DicomTag kModality{0x0008, 0x0060};
constexpr const char* kUtf8 = "ISO_IR 192";

/// Attributes of PS3.3 C.7.1 to C.7.4. Required attributes are written without a value if the image does not have them;
/// optional attributes are copied if present.
constexpr DicomTag kRequired[] = {{0x0010, 0x0010}, {0x0010, 0x0020}, {0x0010, 0x0030}, {0x0010, 0x0040},
                                  {0x0008, 0x0020}, {0x0008, 0x0030}, {0x0008, 0x0050}, {0x0008, 0x0090},
                                  {0x0020, 0x0010}, {0x0020, 0x1040}};
constexpr DicomTag kOptional[] = {{0x0020, 0x000d}, {0x0008, 0x1030}, {0x0010, 0x1010},
                                  {0x0010, 0x1020}, {0x0010, 0x1030}, {0x0010, 0x0021}};

/// Other attributes that copy_context() reads.
constexpr DicomTag kOthers[] = {{0x0012, 0x0062}, {0x0012, 0x0063},  {0x0020, 0x000e},
                                {0x0028, 0x2110}, {0x0028, 0x2112},  {0x0028, 0x2114},
                                kCharacterSet,    kFrameOfReference, kModality};

/// Texts of an image, read in one request.
class ImageTexts {
 public:
  explicit ImageTexts(const fs::path& image) {
    std::vector<DicomTag> tags(std::begin(kRequired), std::end(kRequired));
    tags.insert(tags.end(), std::begin(kOptional), std::end(kOptional));
    tags.insert(tags.end(), std::begin(kOthers), std::end(kOthers));
    const std::vector<std::string> values = read_dicom_values(image, tags);
    for (std::size_t n = 0; n < tags.size(); ++n) texts_[{tags[n].group, tags[n].element}] = values[n];
  }
  const std::string& raw(DicomTag tag) const { return texts_.at({tag.group, tag.element}); }
  std::string line(DicomTag tag) const { return one_line(raw(tag), 200); }

 private:
  std::map<std::pair<std::uint16_t, std::uint16_t>, std::string> texts_;
};

/// Copies the texts of the image with a true declaration of their character set: the bytes as they are for a known set
/// other than UTF-8, otherwise UTF-8. Texts that are not UTF-8, although no or another set is declared, are converted
/// by as_utf8() with an unknown character set.
void copy_context(const ImageTexts& image, DicomSource& source) {
  DicomItem& context = source.context;
  const std::string coding = image.line(kCharacterSet);
  source.unicode = coding == kUtf8 || !is_known_character_set(coding);
  const auto copy = [&](DicomTag tag) {
    const std::string text = source.unicode ? as_utf8(image.raw(tag), "") : image.raw(tag);
    if (!text.empty()) context.text(tag, text);
    return !text.empty();
  };
  for (const DicomTag tag : kRequired)
    if (!copy(tag)) context.text(tag, "");
  for (const DicomTag tag : kOptional) copy(tag);
  // PatientIdentityRemoved is only valid together with DeidentificationMethod.
  if (copy({0x0012, 0x0063})) copy({0x0012, 0x0062});
  if (source.unicode)
    context.text(kCharacterSet, kUtf8);
  else
    copy(kCharacterSet);
  source.study = image.line({0x0020, 0x000d});
  source.series = image.line({0x0020, 0x000e});
  source.modality = image.line(kModality);
  source.frame_of_reference = image.line(kFrameOfReference);
  if (source.frame_of_reference.empty()) source.frame_of_reference = new_dicom_uid();
  context.text(kFrameOfReference, source.frame_of_reference);
  if (image.line({0x0028, 0x2110}) == "01") {
    source.lossy_ratio = image.line({0x0028, 0x2112});
    source.lossy_method = image.line({0x0028, 0x2114});
  }
}

}  // namespace

DicomItem DicomSource::reference(std::size_t slice) const {
  const DicomInstance& instance = slices[slice];
  DicomItem item;
  item.text({0x0008, 0x1150}, instance.sop_class).text({0x0008, 0x1155}, instance.sop_instance);
  if (instance.frame > 0) item.text({0x0008, 0x1160}, std::to_string(instance.frame));
  return item;
}

std::vector<DicomItem> DicomSource::references() const {
  std::vector<DicomItem> items;
  std::set<std::string> named;
  for (const DicomInstance& instance : slices) {
    if (!named.insert(instance.sop_instance).second) continue;
    items.emplace_back().text({0x0008, 0x1150}, instance.sop_class).text({0x0008, 0x1155}, instance.sop_instance);
  }
  return items;
}

DicomSource read_dicom_source(const fs::path& path, const fs::path& target, int volume, const std::string& series) {
  const std::string what = "cannot write " + quoted(target);
  if (path.empty())
    throw Error(what, "it must refer to DICOM images, but there is no volume",
                "use .nii.gz, .nii, .seg.nrrd, .nrrd or .mha");
  const VolumeSource opened = open_volume(path, volume, series);
  if (opened.dicom.empty()) {
    throw Error(what, "it must refer to DICOM images, but the volume " + quoted(path) + " is " + opened.info.format,
                "use .nii.gz, .nii, .seg.nrrd, .nrrd or .mha, or segment the DICOM series itself");
  }
  DicomSource source;
  source.geometry = opened.info.geometry;
  for (const DicomSlice& slice : opened.dicom) {
    if (!slice.position || !slice.axes || slice.sop_instance.empty() || slice.sop_class.empty()) {
      throw Error(what, name_of(slice) + " of " + quoted(path) + " has no position, orientation or SOP instance UID",
                  "use .nii.gz, .nii, .seg.nrrd, .nrrd or .mha");
    }
    source.slices.push_back(
        {slice.sop_class, slice.sop_instance, slice.pixels.frames > 1 ? slice.frame + 1 : 0, *slice.position});
  }
  try {
    copy_context(ImageTexts(opened.dicom.front().file), source);
  } catch (const WorkerUnavailable&) {
    throw;
  } catch (const std::exception& exception) {
    throw Error(what, quoted(opened.dicom.front().file) + " cannot be read: " + message_of(exception),
                "check the file");
  }
  if (source.study.empty() || source.series.empty()) {
    throw Error(what, "the images in " + quoted(path) + " have no study or series UID",
                "use .nii.gz, .nii, .seg.nrrd, .nrrd or .mha");
  }
  return source;
}

std::string dicom_name(const std::string& name, const DicomSource& source, std::size_t max_characters) {
  std::string text;
  std::size_t characters = 0;
  for (const char c : one_line(as_utf8(name, ""), 4 * max_characters)) {
    const auto byte = static_cast<unsigned char>(c);
    const bool continues = (byte & 0xc0) == 0x80;
    if (!continues && ++characters > max_characters) break;
    if (byte >= 0x80 && !source.unicode) {
      if (!continues) text += '?';
      continue;
    }
    text += c == '\\' ? '/' : c;
  }
  text.erase(text.find_last_not_of(' ') + 1);  // spaces at the end are padding
  return text.empty() ? "unnamed" : text;
}

std::vector<std::string> dicom_names(const std::vector<std::string>& names, const DicomSource& source,
                                     std::size_t max_characters) {
  std::vector<std::string> texts;
  std::set<std::string> used;
  std::map<std::string, std::size_t> next;  // number of the next suffix for a text without suffix
  for (const std::string& name : names) {
    const std::string whole = dicom_name(name, source, max_characters);
    std::string text = whole;
    for (std::size_t& number = next.try_emplace(whole, 2).first->second; !used.insert(text).second; ++number) {
      std::string suffix(1, '-');
      suffix += std::to_string(number);
      text = dicom_name(name, source, max_characters - suffix.size()) + suffix;
    }
    texts.push_back(text);
  }
  return texts;
}

void add_segment_code(DicomItem& item, DicomTag type, const SegmentCode& code, const DicomSource& source) {
  const SegmentCode& used = code.empty() ? tissue_code() : code;
  const auto item_of = [&](const CodedConcept& one) {
    DicomItem coded;
    coded.text({0x0008, 0x0100}, one.value).text({0x0008, 0x0102}, one.scheme);
    coded.text({0x0008, 0x0104}, dicom_name(one.meaning, source));
    return coded;
  };
  DicomItem coded_type = item_of(used.type);
  if (!used.modifier.empty()) coded_type.item({0x0062, 0x0011}, item_of(used.modifier));
  item.item({0x0062, 0x0003}, item_of(used.category)).item(type, coded_type);
}

DicomDateTime dicom_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  char date[16], time[16];
  std::strftime(date, sizeof date, "%Y%m%d", &parts);
  std::strftime(time, sizeof time, "%H%M%S", &parts);
  return {date, time};
}

void add_common_attributes(DicomItem& data, const std::string& sop_class, const std::string& modality,
                           const DicomDateTime& now) {
  data.text({0x0008, 0x0016}, sop_class).text({0x0008, 0x0018}, new_dicom_uid());
  data.text({0x0008, 0x0060}, modality).text({0x0020, 0x000e}, new_dicom_uid());
  data.text({0x0020, 0x0011}, "1").text({0x0020, 0x0013}, "1");
  data.text({0x0008, 0x0012}, now.date).text({0x0008, 0x0013}, now.time);
  data.text({0x0008, 0x0021}, now.date).text({0x0008, 0x0031}, now.time);
  data.text({0x0008, 0x0070}, "SimplexSeg").text({0x0008, 0x1090}, "SimplexSeg");
  data.text({0x0018, 0x1000}, "none").text({0x0018, 0x1020}, SIMPLEXSEG_VERSION);
}

}  // namespace simplexseg
