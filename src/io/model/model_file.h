// SPDX-License-Identifier: Apache-2.0
// Files of statistical models (docs/models.md).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "model/organ_model.h"
#include "model/pose_relations.h"

namespace simplexseg {

/// Extension of model files, with its period.
inline constexpr const char* kModelExtension = ".model";

/// Contents of a model file; no image.
struct ModelFile {
  std::vector<OrganModel> organs;
  PoseRelations relations;  ///< of several organs
  std::string checksum;     ///< of the contents, set by read_model() and write_model()
};

/// Bytes of a model file: CBOR with the arrays in little-endian order, and a CRC-32 of them.
std::string model_bytes(const ModelFile& model);
/// Model from the bytes of a file. `name`: file in messages. Throws Error for damaged bytes, another version, and
/// arrays whose lengths do not match.
ModelFile model_from_bytes(const std::string& bytes, const std::string& name);

/// Index of an organ by its name. Throws Error for a name that the model does not have.
int organ_of_name(const ModelFile& model, const std::string& name, const std::string& file);

ModelFile read_model(const std::filesystem::path& path);
void write_model(const std::filesystem::path& path, ModelFile& model);

}  // namespace simplexseg
