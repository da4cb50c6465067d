// SPDX-License-Identifier: Apache-2.0
#include "io/dicom_slice.h"

#include <gdcmReader.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <locale>
#include <sstream>

#include "io/files.h"
#include "io/itk_quiet.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

std::string text_of(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element) {
  const gdcm::Tag tag(group, element);
  if (!data.FindDataElement(tag)) return {};
  const gdcm::ByteValue* value = data.GetDataElement(tag).GetByteValue();
  return value ? one_line(std::string(value->GetPointer(), value->GetLength()), 200) : std::string();
}

/// The backslash-separated numbers of a text attribute; nothing unless there are `count` finite ones.
template <int count>
std::optional<Eigen::Matrix<double, count, 1>> numbers_of(const gdcm::DataSet& data, std::uint16_t group,
                                                          std::uint16_t element) {
  std::string text = text_of(data, group, element);
  std::replace(text.begin(), text.end(), '\\', ' ');
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  Eigen::Matrix<double, count, 1> numbers;
  for (int i = 0; i < count; ++i) {
    if (!(stream >> numbers[i]) || !std::isfinite(numbers[i])) return {};
  }
  return numbers;
}

/// An attribute of 16 bits; GDCM has put it in the machine's byte order.
int short_of(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element, int otherwise) {
  const gdcm::Tag tag(group, element);
  if (!data.FindDataElement(tag)) return otherwise;
  const gdcm::ByteValue* value = data.GetDataElement(tag).GetByteValue();
  if (!value || value->GetLength() < 2) return otherwise;
  std::uint16_t number;
  std::memcpy(&number, value->GetPointer(), 2);
  return number;
}

/// Whether the compressed fragments of the pixel data, whose first item begins at `position`, end within the file.
bool fragments_are_whole(std::istream& stream, std::uint64_t position, std::uint64_t file_bytes) {
  while (position + 8 <= file_bytes) {
    std::uint16_t tag[2];
    std::uint32_t length;
    stream.seekg(static_cast<std::streamoff>(position));
    if (!stream.read(reinterpret_cast<char*>(tag), 4) || !stream.read(reinterpret_cast<char*>(&length), 4))
      return false;
    if (tag[0] != 0xfffe) return false;
    if (tag[1] == 0xe0dd) return true;
    position += 8 + std::uint64_t(length);
  }
  return position == file_bytes;  // some writers leave out the closing delimiter
}

/// Whether the file ends before the pixels that begin at `start` do: GDCM gives what is there of them and leaves the
/// rest as it was. `wanted`: the fewest bytes that they take where they are not compressed (subsampled colours take two
/// thirds).
bool ends_early(const fs::path& path, const gdcm::TransferSyntax& syntax, std::size_t start, double wanted) {
  // Where the whole file is deflated, positions within it are not known.
  if (syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian) return false;
  const std::uint64_t file_bytes = fs::file_size(path);
  if (!syntax.IsEncapsulated()) return double(start) + wanted > double(file_bytes);
  std::ifstream stream(path, std::ios::binary);
  return !fragments_are_whole(stream, start, file_bytes);
}

}  // namespace

std::optional<DicomSlice> scan_dicom(const fs::path& path) {
  std::optional<DicomSlice> result;
  without_aborting([&] {
    const gdcm::Tag pixel_data(0x7fe0, 0x0010);
    gdcm::Reader reader;
    reader.SetFileName(path.c_str());
    if (!reader.ReadUpToTag(pixel_data, {pixel_data})) return;  // stops where the pixels begin
    const gdcm::DataSet& data = reader.GetFile().GetDataSet();
    const gdcm::TransferSyntax& syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
    DicomSlice slice;
    slice.file = path;
    slice.series = text_of(data, 0x0020, 0x000e);
    slice.description = text_of(data, 0x0008, 0x103e);
    slice.rows = short_of(data, 0x0028, 0x0010, 0);
    slice.columns = short_of(data, 0x0028, 0x0011, 0);
    slice.samples = short_of(data, 0x0028, 0x0002, 1);
    const int bits = short_of(data, 0x0028, 0x0100, 0);
    if (const auto n = numbers_of<1>(data, 0x0028, 0x0008)) slice.frames = int(std::clamp((*n)[0], 1.0, 1e8));
    const std::size_t start = reader.GetStreamCurrentPosition();
    if (slice.rows < 1 || slice.columns < 1 || bits < 1 || start == std::size_t(-1)) return;
    slice.position = numbers_of<3>(data, 0x0020, 0x0032);
    if (const auto n = numbers_of<6>(data, 0x0020, 0x0037)) {
      Eigen::Matrix<double, 3, 2> axes;
      axes << n->head<3>(), n->tail<3>();
      // Written with few digits, so unit length is restored; what is no pair of axes is left out.
      if (axes.col(0).norm() > 0.5 && axes.col(1).norm() > 0.5) {
        axes.colwise().normalize();
        if (std::abs(axes.col(0).dot(axes.col(1))) < 0.1) slice.axes = axes;
      }
    }
    for (const auto& [group, element] : {std::pair{0x0028, 0x0030}, std::pair{0x0018, 0x1164}}) {
      // PixelSpacing (ImagerPixelSpacing): between rows, then between columns.
      const auto n = numbers_of<2>(data, std::uint16_t(group), std::uint16_t(element));
      if (!slice.spacing_mm && n && n->minCoeff() > 0) slice.spacing_mm = Eigen::Vector2d((*n)[1], (*n)[0]);
    }
    if (const auto n = numbers_of<1>(data, 0x0018, 0x0088)) slice.between_mm = std::abs((*n)[0]);
    if (const auto n = numbers_of<1>(data, 0x0018, 0x0050)) slice.thickness_mm = (*n)[0];
    const auto slope = numbers_of<1>(data, 0x0028, 0x1053), intercept = numbers_of<1>(data, 0x0028, 0x1052);
    std::ostringstream kind;
    kind << bits << ' ' << short_of(data, 0x0028, 0x0101, 0) << ' ' << short_of(data, 0x0028, 0x0103, 0) << ' '
         << (slope ? (*slope)[0] : 1) << ' ' << (intercept ? (*intercept)[0] : 0);
    slice.pixel_kind = kind.str();

    if (syntax == gdcm::TransferSyntax::ExplicitVRBigEndian && bits > 16)
      slice.unreadable = "its pixels are big-endian with more than 16 bits, which GDCM reads wrongly";
    const double wanted = double(slice.rows) * slice.columns * slice.samples * slice.frames * bits / 8;
    if (ends_early(path, syntax, start, slice.samples > 1 ? 0.66 * wanted : wanted))
      slice.unreadable = "truncated: the file ends before its pixels do";
    result = slice;
  });
  return result;
}

std::string name_of(const DicomSlice& slice) { return quoted(slice.file.filename()); }

std::string list_of(const std::vector<std::string>& names, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < most; ++i) text += (i ? ", " : "") + names[i];
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

}  // namespace simplexseg
