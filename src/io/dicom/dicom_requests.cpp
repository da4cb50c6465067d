// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_requests.h"

#include <gdcmReader.h>

#include "io/dicom/dicom_values.h"
#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

std::vector<std::string> in_reader::read_dicom_values(const fs::path& path, const std::vector<DicomTag>& tags) {
  constexpr std::size_t max_text = 10240;  // longest text that several values of the standard can form
  const gdcm::Tag pixel_data(0x7fe0, 0x0010);
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.ReadUpToTag(pixel_data, {pixel_data})) throw std::runtime_error("it is damaged");
  const gdcm::File& file = reader.GetFile();
  std::vector<std::string> texts;
  for (const DicomTag tag : tags) {
    const char* const syntax = file.GetHeader().GetDataSetTransferSyntax().GetString();
    const bool is_syntax = tag.group == kTransferSyntax.group && tag.element == kTransferSyntax.element;
    std::string text = is_syntax ? std::string(syntax ? syntax : "") : raw_text_of(file.GetDataSet(), tag);
    if (text.empty() && !is_syntax)
      first_item(file.GetDataSet(), {0x0054, 0x0016},
                 [&](const gdcm::DataSet& item) { text = raw_text_of(item, tag); });
    texts.push_back(text.size() > max_text ? std::string() : std::move(text));
  }
  return texts;
}

std::vector<std::string> read_dicom_values(const fs::path& file, const std::vector<DicomTag>& tags) {
  std::vector<std::string> texts = request_result(kDicomTexts, file, limits_for_file(file), tags);
  texts.resize(tags.size());
  return texts;
}

}  // namespace simplexseg
