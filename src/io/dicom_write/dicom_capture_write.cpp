// SPDX-License-Identifier: Apache-2.0
#include "io/dicom_write/dicom_capture_write.h"

#include "io/platform/atomic_file.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

constexpr const char* kSecondaryCapture = "1.2.840.10008.5.1.4.1.1.7";
constexpr int kMaxCapturePixels = 65535;

}  // namespace

void write_secondary_capture(const std::filesystem::path& path, const Picture& picture, const std::string& description,
                             DicomSource source) {
  if (picture.width < 1 || picture.height < 1 || picture.width > kMaxCapturePixels ||
      picture.height > kMaxCapturePixels)
    throw Error("cannot write " + quoted(path),
                "the picture has " + std::to_string(picture.width) + " x " + std::to_string(picture.height) + " pixels",
                "choose a size of 1 to 65535 pixels per side");
  DicomItem data = std::move(source.context);
  data.remove({0x0020, 0x0052}).remove({0x0020, 0x1040});  // a screen capture has no position in space
  const DicomDateTime now = dicom_now();
  add_common_attributes(data, kSecondaryCapture, "OT", now);
  data.text({0x0008, 0x0023}, now.date).text({0x0008, 0x0033}, now.time);
  data.text({0x0008, 0x0008}, "DERIVED\\SECONDARY").text({0x0008, 0x0064}, "WSD");
  data.text({0x0008, 0x103e}, dicom_name(description, source)).text({0x0020, 0x0020}, "").text({0x0020, 0x0060}, "");
  const auto number = [&](DicomTag tag, int value) {
    const std::uint16_t values[] = {static_cast<std::uint16_t>(value)};
    data.shorts(tag, values);
  };
  data.text({0x0028, 0x0004}, "RGB").text({0x0028, 0x0301}, "YES");  // the picture can show names
  number({0x0028, 0x0002}, 3), number({0x0028, 0x0006}, 0);
  number({0x0028, 0x0010}, picture.height), number({0x0028, 0x0011}, picture.width);
  number({0x0028, 0x0100}, 8), number({0x0028, 0x0101}, 8), number({0x0028, 0x0102}, 7), number({0x0028, 0x0103}, 0);
  std::vector<std::uint8_t> pixels = picture.rgb;
  if (pixels.size() % 2) pixels.push_back(0);
  data.bytes({0x7fe0, 0x0010}, pixels);
  AtomicFile file(path);
  write_dicom(file, data, DicomCoding::Explicit);
  file.commit();
}

}  // namespace simplexseg
