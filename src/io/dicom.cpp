// SPDX-License-Identifier: Apache-2.0
#include <gdcmReader.h>
#include <itkGDCMImageIO.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <locale>
#include <map>
#include <optional>
#include <sstream>
#include <vector>

#include "io/files.h"
#include "io/itk_quiet.h"
#include "io/itk_types.h"
#include "io/volume_source.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

/// What the header of one DICOM image says. Attributes: DICOM PS3.3, C.7.6.2 (image plane) and C.7.6.3 (pixels).
struct Slice {
  fs::path file;
  std::string series, description;
  int rows = 0, columns = 0, frames = 1, samples = 1;
  std::optional<Eigen::Vector3d> position;          ///< of the first pixel's centre, LPS mm
  std::optional<Eigen::Matrix<double, 3, 2>> axes;  ///< of the columns (i) and rows (j)
  std::optional<Eigen::Vector2d> spacing_mm;        ///< along i and j
  std::optional<double> between_mm, thickness_mm;
  std::string pixel_kind;  ///< bits, sign and rescaling: equal for slices of one type
  std::string unreadable;  ///< why its pixels cannot be read; empty when they can
};

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

/// Reads the header; nothing when the file is not DICOM or holds no image. Throws std::exception on a damaged file.
std::optional<Slice> scan(const fs::path& path) {
  std::optional<Slice> result;
  without_aborting([&] {
    const gdcm::Tag pixel_data(0x7fe0, 0x0010);
    gdcm::Reader reader;
    reader.SetFileName(path.c_str());
    if (!reader.ReadUpToTag(pixel_data, {pixel_data})) return;  // stops where the pixels begin
    const gdcm::DataSet& data = reader.GetFile().GetDataSet();
    const gdcm::TransferSyntax& syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
    Slice slice;
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

    // GDCM gives what is there of the pixels and leaves the rest as it was. (Subsampled colours take two thirds.)
    std::ifstream stream(path, std::ios::binary);
    const std::uint64_t file_bytes = fs::file_size(path);
    const double wanted = double(slice.rows) * slice.columns * slice.samples * slice.frames * bits / 8;
    if (syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian) {
      // Positions within the file are not known.
    } else if (syntax.IsEncapsulated()
                   ? !fragments_are_whole(stream, start, file_bytes)
                   : double(start) + (slice.samples > 1 ? 0.66 : 1.0) * wanted > double(file_bytes)) {
      slice.unreadable = "truncated: the file ends before its pixels do";
    } else if (syntax == gdcm::TransferSyntax::ExplicitVRBigEndian && bits > 16) {
      slice.unreadable = "its pixels are big-endian with more than 16 bits, which GDCM reads wrongly";
    }
    result = slice;
  });
  return result;
}

std::string name_of(const Slice& slice) { return quoted(slice.file.filename()); }

/// "'a', 'b' and 3 more".
std::string list_of(const std::vector<std::string>& names, std::size_t most = 12) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < most; ++i) text += (i ? ", " : "") + names[i];
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

std::string mm(double length) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g mm", length);
  return text;
}

using Slices = std::vector<Slice>;

/// All slices must be of one size, one spacing and one orientation, and have a position. `what` names the series.
void require_one_stack(const Slices& slices, const std::string& what) {
  const Slice& first = slices.front();
  std::vector<std::string> unplaced, sizes, orientations, many;
  for (const Slice& s : slices) {
    if (!s.position || !s.axes) unplaced.push_back(name_of(s));
    if (s.rows != first.rows || s.columns != first.columns ||
        s.spacing_mm.has_value() != first.spacing_mm.has_value() ||
        (s.spacing_mm && !s.spacing_mm->isApprox(*first.spacing_mm, 1e-3))) {
      sizes.push_back(name_of(s));
    }
    if (s.axes && first.axes && (*s.axes - *first.axes).cwiseAbs().maxCoeff() > 1e-3)
      orientations.push_back(name_of(s));
    if (s.frames > 1) many.push_back(name_of(s));
  }
  if (!many.empty()) {
    throw Error("cannot read " + what, "it has several files of many frames each: " + list_of(many),
                "open one of these files alone");
  }
  if (!orientations.empty()) {
    throw Error("cannot read " + what,
                "its slices have different orientations: " + list_of(orientations) + " differ from " + name_of(first),
                "put slices of one orientation into a folder of their own");
  }
  if (!sizes.empty()) {
    throw Error(
        "cannot read " + what,
        "its slices have different sizes or pixel spacings: " + list_of(sizes) + " differ from " + name_of(first),
        "put slices of one size into a folder of their own");
  }
  if (!unplaced.empty()) {
    throw Error("cannot read " + what, "these slices have no position or orientation: " + list_of(unplaced),
                "export the series again with its image positions");
  }
}

/// Orders the slices by their place along the normal and sets spacing, origin and direction. Missing and doubled slices
/// are all named in one Error.
void stack(Slices& slices, VolumeGeometry& geometry, std::vector<std::string>& warnings, const std::string& what) {
  const Eigen::Vector3d normal = slices.front().axes->col(0).cross(slices.front().axes->col(1)).normalized();
  const auto place = [&](const Slice& s) { return normal.dot(*s.position); };
  std::sort(slices.begin(), slices.end(),
            [&](const Slice& a, const Slice& b) { return std::pair(place(a), a.file) < std::pair(place(b), b.file); });
  constexpr double same_mm = 0.01;
  std::vector<double> gaps;
  std::vector<std::string> doubled, missing, uneven;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    const double gap = place(slices[i]) - place(slices[i - 1]);
    if (gap > same_mm)
      gaps.push_back(gap);
    else
      doubled.push_back(name_of(slices[i - 1]) + " and " + name_of(slices[i]));
  }
  double spacing = 0;
  if (!gaps.empty()) {
    std::vector<double> sorted = gaps;
    std::nth_element(sorted.begin(), sorted.begin() + (sorted.size() - 1) / 2, sorted.end());
    spacing = sorted[(sorted.size() - 1) / 2];
  }
  double worst = 0;
  int lacking = 0;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    const double gap = place(slices[i]) - place(slices[i - 1]);
    if (gap <= same_mm) continue;
    const double ratio = gap / spacing;
    const int steps = static_cast<int>(std::lround(std::min(ratio, 1e6)));
    const std::string between = name_of(slices[i - 1]) + " and " + name_of(slices[i]);
    if (steps >= 2 && std::abs(ratio - steps) < 0.1 * steps) {
      missing.push_back(std::to_string(steps - 1) + " between " + between);
      lacking += steps - 1;
    } else if (std::abs(ratio - 1) > 0.1) {
      uneven.push_back(mm(gap) + " between " + between);
    } else {
      worst = std::max(worst, std::abs(gap - spacing));
    }
  }
  if (!doubled.empty() || !missing.empty() || !uneven.empty()) {
    std::string why, todo;
    const auto add = [](std::string& to, const std::string& text) { to += (to.empty() ? "" : ", ") + text; };
    if (!missing.empty()) add(why, std::to_string(lacking) + " missing slice(s) (" + list_of(missing) + ")");
    if (!doubled.empty()) add(why, std::to_string(doubled.size()) + " doubled slice(s) (" + list_of(doubled) + ")");
    if (!uneven.empty()) add(why, "uneven slice distances (" + list_of(uneven) + " instead of " + mm(spacing) + ")");
    if (!missing.empty()) add(todo, "add the missing files");
    if (!doubled.empty()) add(todo, "leave one file for each position");
    if (!uneven.empty()) add(todo, "put each stack of evenly spaced slices into a folder of its own");
    throw Error("cannot read " + what, why, todo);
  }
  const Slice& first = slices.front();
  geometry.origin_mm = *first.position;
  geometry.direction.leftCols<2>() = *first.axes;
  geometry.direction.col(2) = normal;
  if (slices.size() == 1) return;

  const double count = double(slices.size() - 1);
  const Eigen::Vector3d step = (*slices.back().position - *first.position) / count;
  const double along = normal.dot(step), lean = (step - along * normal).norm() / along;
  double off_line = 0;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const Eigen::Vector3d off = *slices[i].position - *first.position - double(i) * step;
    off_line = std::max(off_line, (off - normal.dot(off) * normal).norm());
  }
  const double pixel = first.spacing_mm ? first.spacing_mm->minCoeff() : 1;
  if (off_line > 0.5 * pixel) {
    throw Error("cannot read " + what, "its slices are shifted against each other by up to " + mm(off_line),
                "export the series again, or put each stack into a folder of its own");
  }
  if (off_line > 0.1 * pixel) warnings.push_back("slices lie up to " + mm(off_line) + " beside a straight stack");
  // A lean of rounding's size is none; a real one (tilted gantry) is kept as it is: the grid is sheared.
  geometry.spacing_mm[2] = lean < 1e-4 ? along : step.norm();
  if (lean >= 1e-4) geometry.direction.col(2) = step.normalized();
  if (lean > 1e-3) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "tilted gantry: the slices are stacked %.3g degrees off their normal; the volume is "
                  "kept as it was taken (a sheared grid)",
                  std::atan(lean) * 180 / M_PI);
    warnings.push_back(text);
  }
  if (worst > 0.02 * spacing) {
    warnings.push_back("slice distances vary by up to " + mm(worst) + "; " + mm(along) + " is taken for all");
  }
  if (first.between_mm && *first.between_mm > 0 && std::abs(*first.between_mm - along) > 0.02 * along) {
    warnings.push_back("slices lie " + mm(along) + " apart, though the header says " + mm(*first.between_mm));
  }
  if (slices.size() < 3) {
    warnings.push_back("only " + std::to_string(slices.size()) + " slices: a missing one would not be noticed");
  }
}

itk::GDCMImageIO::Pointer open_pixels(const Slice& slice) {
  const auto io = itk::GDCMImageIO::New();
  try {
    without_aborting([&] {
      if (!io->CanReadFile(slice.file.c_str())) throw std::runtime_error("its pixels are coded in an unknown way");
      io->SetFileName(slice.file.string());
      io->ReadImageInformation();
    });
  } catch (const Error&) {
    throw;
  } catch (const std::exception& exception) {
    throw Error("cannot read " + quoted(slice.file), plain_words(exception), "copy or export the file again");
  }
  return io;
}

void require_readable(const Slices& slices) {
  std::vector<std::string> names;
  std::string why;
  for (const Slice& s : slices) {
    if (s.unreadable.empty()) continue;
    if (why.empty()) why = s.unreadable;
    names.push_back(name_of(s));
  }
  if (names.empty()) return;
  if (slices.size() > 1) why += ": " + list_of(names);
  throw Error("cannot read " + quoted(slices.size() == 1 ? slices[0].file : slices[0].file.parent_path()), why,
              "copy or export it again");
}

Volume read_slices(const Slices& slices, const VolumeInfo& info) {
  const QuietLibraries quiet;
  require_readable(slices);
  Volume volume(info.geometry, info.type);
  const std::size_t count = info.geometry.voxel_count() / slices.size();
  std::vector<unsigned char> other;  // for a slice whose type is not the volume's
  for (std::size_t k = 0; k < slices.size(); ++k) {
    const auto io = open_pixels(slices[k]);
    const ItkVoxels voxels = itk_voxels_of(*io, quoted(slices[k].file));
    const std::size_t bytes = static_cast<std::size_t>(io->GetImageSizeInBytes());
    if (io->GetNumberOfComponents() != 1 || voxels.wide || bytes != count * bytes_per_voxel(voxels.type)) {
      throw Error("cannot read " + quoted(slices[k].file),
                  "its pixels are of another kind than those of the other slices",
                  "put slices of one kind into a folder of their own");
    }
    auto* to = static_cast<unsigned char*>(volume.data()) + k * count * bytes_per_voxel(info.type);
    const bool direct = voxels.type == info.type;
    if (!direct) other.resize(bytes);
    try {
      without_aborting([&] { read_whole(*io, direct ? to : other.data()); });
    } catch (const std::exception& exception) {
      throw Error("cannot read " + quoted(slices[k].file), plain_words(exception), "copy or export the file again");
    }
    if (direct) continue;
    visit_voxel_type(voxels.type, [&]<class From>(std::type_identity<From>) {
      const auto* from = reinterpret_cast<const From*>(other.data());
      visit_voxel_type(info.type, [&]<class To>(std::type_identity<To>) {
        std::transform(from, from + count, reinterpret_cast<To*>(to), [](From v) { return static_cast<To>(v); });
      });
    });
  }
  return volume;
}

/// The volume of slices that are known to be of one series; `what` names it in messages.
VolumeSource open_slices(Slices slices, const std::string& format, const std::string& what) {
  VolumeSource source;
  VolumeInfo& info = source.info;
  info.format = format;
  info.file_count = static_cast<int>(slices.size());
  if (slices.size() > 1) require_one_stack(slices, what);
  const Slice first = slices.front();
  if (slices.size() == 1 && first.frames > 1) {
    // The frames' places are in nested sequences (or in a dose grid's offsets): GDCM knows them.
    describe(*open_pixels(first), info);
    info.warnings.push_back("many frames in one file: they are taken as evenly spaced slices in their order");
  } else {
    info.geometry.size = {first.columns, first.rows, static_cast<int>(slices.size())};
    if (first.spacing_mm)
      info.geometry.spacing_mm.head<2>() = *first.spacing_mm;
    else
      info.warnings.push_back("no pixel spacing: 1 mm is assumed");
    if (slices.size() == 1) {
      const auto thick = first.between_mm && *first.between_mm > 0 ? first.between_mm : first.thickness_mm;
      if (thick && *thick > 0) info.geometry.spacing_mm[2] = *thick;
    }
    if (first.position && first.axes) {
      stack(slices, info.geometry, info.warnings, what);
    } else {
      info.warnings.push_back("no position or orientation: which side is the patient's left is not known");
    }
  }
  const auto io = open_pixels(slices.front());
  info.components = static_cast<int>(io->GetNumberOfComponents());
  info.type = itk_voxels_of(*io, quoted(slices.front().file)).type;
  for (const Slice& s : slices) {
    if (s.pixel_kind != first.pixel_kind) info.type = VoxelType::Float32;  // rescaled differently from slice to slice
  }
  info.geometry.validate("cannot read " + what);
  if (info.components == 1) require_readable(slices);
  source.read = [slices = std::move(slices), info] { return read_slices(slices, info); };
  return source;
}

}  // namespace

bool looks_like_dicom(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  char magic[4] = {};
  stream.seekg(128);
  return stream.read(magic, 4) && std::memcmp(magic, "DICM", 4) == 0;
}

VolumeSource open_dicom_file(const fs::path& path) {
  require_file(path);
  const QuietLibraries quiet;
  std::optional<Slice> slice;
  try {
    slice = scan(path);
  } catch (const std::exception& exception) {
    throw Error("cannot read " + quoted(path), plain_words(exception), "copy or export the file again");
  }
  if (!slice) {
    if (looks_like_dicom(path)) {
      throw Error("cannot read " + quoted(path), "this DICOM file holds no image",
                  "open the folder of an image series");
    }
    throw Error("cannot read " + quoted(path), "it is none of the formats that can be read",
                "give NIfTI, Analyze, MetaImage, NRRD, MINC 2, a DICOM file, or the folder of a DICOM series");
  }
  VolumeSource source = open_slices({*slice}, "DICOM", quoted(path));
  if (slice->frames == 1) source.info.warnings.push_back("one DICOM slice: open its folder for the whole series");
  return source;
}

VolumeSource open_dicom_series(const fs::path& folder) {
  const QuietLibraries quiet;
  std::error_code error;
  std::vector<fs::path> files;
  bool has_folders = false;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (it->is_directory(ignored)) has_folders = true;
    if (it->is_regular_file(ignored) && it->file_size(ignored) > 0) files.push_back(it->path());
  }
  if (error) throw Error("cannot read the folder " + quoted(folder), error.message(), "check its permissions");
  std::sort(files.begin(), files.end());
  std::map<std::string, Slices> series;
  std::vector<std::string> broken;
  for (const fs::path& file : files) {
    try {
      if (std::optional<Slice> slice = scan(file)) series[slice->series].push_back(std::move(*slice));
    } catch (const std::exception&) {
      broken.push_back(quoted(file.filename()));
    }
  }
  if (series.empty()) {
    throw Error(
        "cannot read the folder " + quoted(folder),
        broken.empty() ? "it holds no DICOM images" : "its DICOM files are damaged: " + list_of(broken),
        has_folders ? "name one of its subfolders, which are not searched" : "name a file or the folder of a series");
  }
  const auto size_of = [](const Slices& slices) {
    std::size_t count = 0;
    for (const Slice& s : slices) count += static_cast<std::size_t>(s.frames);
    return count;
  };
  const auto largest = std::max_element(series.begin(), series.end(), [&](const auto& a, const auto& b) {
    return size_of(a.second) < size_of(b.second);
  });
  const auto named = [&](const Slices& slices) {
    const std::string& text = slices.front().description.empty() ? slices.front().series : slices.front().description;
    return "'" + text + "' (" + std::to_string(size_of(slices)) + " slices, from " + name_of(slices.front()) + ")";
  };
  std::vector<std::string> others;
  for (auto it = series.begin(); it != series.end(); ++it) {
    if (it != largest) others.push_back(named(it->second));
  }
  const std::string chosen = named(largest->second);
  VolumeSource source =
      open_slices(std::move(largest->second), "DICOM series", "the DICOM series in " + quoted(folder));
  if (!others.empty()) {
    source.info.warnings.push_back(std::to_string(others.size() + 1) + " series in the folder: the largest, " + chosen +
                                   ", is taken; left out: " + list_of(others));
  }
  if (!broken.empty()) source.info.warnings.push_back("damaged files are left out: " + list_of(broken));
  return source;
}

}  // namespace simplexseg
