// SPDX-License-Identifier: Apache-2.0
#include "io/transform/transform_io.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"
#include "io/registration/registration_requests.h"
#include "io/transform/itk_parameters.h"
#include "io/volume/nifti.h"
#include "io/volume/nifti_write.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr const char* kTextStart = "#Insight Transform File V1.0";
constexpr const char* kSaveAgain = "save the transform again";
constexpr const char* kComposite = "CompositeTransform";

/// Numbers of a line of a text file.
std::vector<double> numbers_of(const std::string& text, const std::string& name) {
  std::vector<double> numbers;
  for (const std::string& word : words_of(text)) {
    const std::optional<double> number = parse_number(word);
    if (!number) throw Error("cannot read " + name, quoted(word) + " is not a number", kSaveAgain);
    numbers.push_back(*number);
  }
  return numbers;
}

/// Composes the transforms of a file. A composite applies the last of its transforms first; ITK writes it before them.
Transform composed(std::vector<ItkParameters> all, const std::string& name) {
  const bool composite = !all.empty() && all.front().type.starts_with(kComposite);
  if (composite) all.erase(all.begin());
  if (all.empty()) {
    if (composite) return {};
    throw Error("cannot read " + name, "it contains no transform", kSaveAgain);
  }
  if (!composite && all.size() > 1)
    throw Error("cannot read " + name, "it contains several transforms that are no composite", "save one of them");
  Transform result;
  for (auto one = all.rbegin(); one != all.rend(); ++one) result.append(affine_of(*one, name));
  return result;
}

Transform read_text(const fs::path& path) {
  const std::string name = quoted(path);
  HeaderLines lines(path);
  const std::optional<std::string> first = lines.next();
  if (!first || trimmed(*first) != kTextStart) {
    const bool elastix = first && first->starts_with("(");
    throw Error("cannot read " + name, "it does not begin with " + quoted(std::string(kTextStart)),
                elastix ? "let elastix write its transform for ITK (option ITKTransformOutputFileNameExtension)"
                        : "save it as a transform file of ITK (.tfm)");
  }
  std::vector<ItkParameters> all;
  constexpr std::size_t most = 1000;
  while (const std::optional<std::string> line = lines.next()) {
    const std::size_t colon = line->find(':');
    if (line->starts_with('#') || colon == std::string::npos) continue;
    const std::string key = trimmed(line->substr(0, colon)), value = trimmed(line->substr(colon + 1));
    if (key == "Transform") {
      if (all.size() == most) throw Error("cannot read " + name, "it contains too many transforms", kSaveAgain);
      all.push_back({value, {}, {}});
      continue;
    }
    if (key != "Parameters" && key != "FixedParameters") continue;
    if (all.empty()) throw Error("cannot read " + name, "parameters stand before a transform", kSaveAgain);
    (key == "Parameters" ? all.back().parameters : all.back().fixed) = numbers_of(value, name);
  }
  return composed(std::move(all), name);
}

/// Reader of the matrices of a MATLAB file of level 4 (MAT-File Format, appendix A).
class MatrixReader {
 public:
  MatrixReader(std::string bytes, std::string name) : bytes_(std::move(bytes)), name_(std::move(name)) {}
  bool at_end() const { return at_ == bytes_.size(); }

  /// Next matrix: its name, and its values as parameters.
  ItkParameters next() {
    std::array<std::int32_t, 5> head{};  // type, rows, columns, imaginary, length of the name
    copy(head.data(), sizeof head);
    const auto [type, rows, columns, imaginary, length] = head;
    constexpr std::int32_t most = 1000;
    if ((type != 0 && type != 10) || imaginary != 0 || rows < 0 || columns < 0 || rows > most || columns > most ||
        length < 1 || length > most)
      throw damaged();
    std::string label(static_cast<std::size_t>(length), '\0');
    copy(label.data(), label.size());
    ItkParameters result{label.substr(0, label.find('\0')), {}, {}};
    for (std::int64_t n = 0; n < std::int64_t{rows} * columns; ++n) {
      if (type == 10) {
        result.parameters.push_back(static_cast<double>(number<float>()));
      } else {
        result.parameters.push_back(number<double>());
      }
    }
    return result;
  }

 private:
  Error damaged() const {
    return {"cannot read " + name_, "it is not a transform in the MATLAB format of ITK, or damaged",
            "save it as a transform file of ITK (.tfm)"};
  }
  void copy(void* to, std::size_t count) {
    if (count > bytes_.size() - at_) throw damaged();
    std::memcpy(to, bytes_.data() + at_, count);
    at_ += count;
  }
  template <class T>
  T number() {
    T value{};
    copy(&value, sizeof value);
    return value;
  }

  std::string bytes_, name_;
  std::size_t at_ = 0;
};

Transform read_matlab(const fs::path& path) {
  static_assert(std::endian::native == std::endian::little, "the format states the byte order, little-endian here");
  const std::string name = quoted(path);
  require_file(path);
  constexpr std::uintmax_t most = 1 << 20;
  std::error_code error;
  if (fs::file_size(path, error) > most || error)
    throw Error("cannot read " + name, "it is too large for an affine transform", "select another file");
  MatrixReader reader(read_bytes(path), name);
  std::vector<ItkParameters> all;
  while (!reader.at_end()) {
    ItkParameters next = reader.next();
    if (next.type != "fixed") {
      all.push_back(std::move(next));
    } else if (!all.empty()) {
      all.back().fixed = std::move(next.parameters);
    }
  }
  return composed(std::move(all), name);
}

/// Reads an HDF5 file by ITK in the worker process.
Transform read_hdf5(const fs::path& path) {
  require_file(path);
  WorkerLimits limits = limits_for_file(path);
  limits.memory_bytes += std::size_t{8} << 30;  // compressed fields, and the threads of ITK
  limits.cpu_seconds += 60;
  const std::string what = "cannot read " + quoted(path),
                    remedy = "save the affine part as .tfm and the displacement field as .nii.gz";
  try {
    WorkerRequest request(packed_request(kReadHdf5, path), path, limits, {.program = kRegisterProgram});
    const std::vector<TransformStep> steps = result_of(request, kReadHdf5);
    Transform transform;
    for (const TransformStep& step : steps) append_step(transform, step);
    return transform;
  } catch (const WorkerFailure& failure) {
    throw Error(what, failure.what(), remedy);
  } catch (const BadPacking& fault) {
    throw Error(what, fault.what(), remedy);
  }
}

bool is_text(const std::string& extension) { return extension == ".tfm" || extension == ".txt"; }
bool is_field(const std::string& extension) { return extension == ".nii" || extension == ".nii.gz"; }

}  // namespace

Transform read_transform(const fs::path& path) {
  const std::string extension = extension_of(path);
  if (is_text(extension)) return read_text(path);
  if (extension == ".mat") return read_matlab(path);
  if (is_field(extension)) {
    Transform transform;
    transform.append(read_field(path));
    return transform;
  }
  if (extension == ".h5" || extension == ".hdf5") return read_hdf5(path);
  throw Error("cannot read " + quoted(path), "its extension is not that of a transform",
              "use .tfm, .txt, .mat, .h5, or .nii.gz for a displacement field");
}

DisplacementField read_field(const fs::path& path) {
  NiftiVectors read = read_nifti_vectors(path);
  const bool finite =
      std::all_of(read.vectors.begin(), read.vectors.end(), [](const Eigen::Vector3f& v) { return v.allFinite(); });
  if (!finite) throw Error("cannot read " + quoted(path), "a displacement is not finite", "write the field again");
  constexpr int ras = 1006;  // NIFTI_INTENT_DISPVECT
  if (read.intent == ras) {
    for (Eigen::Vector3f& v : read.vectors) v = Eigen::Vector3f(-v[0], -v[1], v[2]);
  }
  return {std::move(read.grid), std::move(read.vectors)};
}

void require_transform_name(const fs::path& path) {
  if (!is_text(extension_of(path)))
    throw Error("cannot write " + quoted(path), "its extension is not that of a transform", "name it .tfm or .txt");
}

void require_field_name(const fs::path& path) {
  if (!is_field(extension_of(path)))
    throw Error("cannot write " + quoted(path), "its extension is not that of a displacement field",
                "name it .nii.gz or .nii");
}

void write_transform(const fs::path& path, const Transform& transform) {
  require_transform_name(path);
  const std::optional<Eigen::Affine3d> affine = transform.affine();
  if (!affine)
    throw Error("cannot write " + quoted(path), "it has no room for a displacement field",
                "write the field as .nii.gz");
  const ItkParameters itk = affine_parameters(*affine);
  std::string text = kTextStart;
  text.append("\n#Transform 0\nTransform: ").append(itk.type).append("\nParameters:");
  for (const double value : itk.parameters) text.append(1, ' ').append(exact_text(value));
  text.append("\nFixedParameters:");
  for (const double value : itk.fixed) text.append(1, ' ').append(exact_text(value));
  text.append(1, '\n');
  AtomicFile file(path);
  write_bytes(file, text);
  file.commit();
}

void write_field(const fs::path& path, const DisplacementField& field) {
  require_field_name(path);
  AtomicFile file(path);
  write_nifti_vectors(file, field.grid(), field.vectors(), extension_of(path) == ".nii.gz");
  file.commit();
}

}  // namespace simplexseg
