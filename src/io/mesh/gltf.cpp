// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/error.h"
#include "io/mesh/mesh_formats.h"
#include "io/platform/bytes.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kMagic = 0x46546c67, kVersion = 2, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;
constexpr int kFloat = 5126, kUnsignedInt = 5125, kVertices = 34962, kIndices = 34963;

/// Intensity of a channel of sRGB (IEC 61966-2-1) in linear light, 0..1.
double linear_of(std::uint8_t channel) {
  const double value = channel / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

/// Unit normals of the vertices: means of the normals of their triangles, by area.
std::vector<Eigen::Vector3f> normals_of(const TriangleMesh& surface) {
  std::vector<Eigen::Vector3f> normals(surface.positions.size(), Eigen::Vector3f::Zero());
  for (const auto& t : surface.triangles) {
    const Eigen::Vector3f& a = surface.positions[t[0]];
    const Eigen::Vector3f across = (surface.positions[t[1]] - a).cross(surface.positions[t[2]] - a);
    for (const int v : t) normals[v] += across;
  }
  for (Eigen::Vector3f& normal : normals)
    normal = normal.squaredNorm() > 0 ? normal.stableNormalized() : Eigen::Vector3f::UnitZ();
  return normals;
}

/// Contents of a file while surfaces are added.
struct Gltf {
  Json nodes = Json::array(), meshes = Json::array(), materials = Json::array(), accessors = Json::array(),
       views = Json::array();
  std::string binary;

  /// Adds a block of vectors of three components to the binary part; returns the index of its accessor.
  template <class Vector>
  std::size_t add(const std::vector<Vector>& values, int component, const char* type, int target) {
    const std::size_t begin = binary.size();
    for (const Vector& value : values)
      for (int a = 0; a < 3; ++a) {
        if (component == kFloat)
          append(binary, static_cast<float>(value[static_cast<std::size_t>(a)]));
        else
          append(binary, static_cast<std::uint32_t>(value[static_cast<std::size_t>(a)]));
      }
    views.push_back({{"buffer", 0}, {"byteOffset", begin}, {"byteLength", binary.size() - begin}, {"target", target}});
    const std::size_t count = target == kIndices ? 3 * values.size() : values.size();
    accessors.push_back(
        {{"bufferView", views.size() - 1}, {"componentType", component}, {"count", count}, {"type", type}});
    return accessors.size() - 1;
  }

  void add(const NamedSurface& surface) {
    const TriangleMesh triangles = tessellate(*surface.mesh);
    const std::size_t position = add(triangles.positions, kFloat, "VEC3", kVertices);
    Eigen::Vector3f low = triangles.positions.front(), high = low;
    for (const Eigen::Vector3f& p : triangles.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
    accessors.back()["min"] = {low.x(), low.y(), low.z()}, accessors.back()["max"] = {high.x(), high.y(), high.z()};
    const std::size_t normal = add(normals_of(triangles), kFloat, "VEC3", kVertices);
    const std::size_t corner = add(triangles.triangles, kUnsignedInt, "SCALAR", kIndices);
    const Colour& c = surface.colour;
    materials.push_back({{"name", surface.name},
                         {"pbrMetallicRoughness",
                          {{"baseColorFactor", {linear_of(c.red), linear_of(c.green), linear_of(c.blue), 1.0}},
                           {"metallicFactor", 0.0},
                           {"roughnessFactor", 0.6}}}});
    const Json attributes = {{"POSITION", position}, {"NORMAL", normal}};
    const Json primitive = {{"attributes", attributes}, {"indices", corner}, {"material", materials.size() - 1}};
    meshes.push_back({{"name", surface.name}, {"primitives", Json::array({primitive})}});
    nodes.push_back({{"name", surface.name}, {"mesh", meshes.size() - 1}});
  }
};

void append_chunk(std::string& file, std::uint32_t type, const std::string& bytes, char padding) {
  const std::size_t padded = (bytes.size() + 3) / 4 * 4;
  append(file, static_cast<std::uint32_t>(padded));
  append(file, type);
  file += bytes;
  file.append(padded - bytes.size(), padding);
}

}  // namespace

std::string glb_of(std::span<const NamedSurface> surfaces) {
  Gltf gltf;
  Json objects = Json::array();
  for (const NamedSurface& surface : surfaces) {
    gltf.add(surface);
    objects.push_back(gltf.nodes.size() - 1);
  }
  // glTF 2.0, 3.4: metres, +Y up, +Z forward, hence left, superior and anterior of a patient as x, y and z. The root
  // turns and scales; coordinates of the meshes remain LPS in mm.
  const double half = std::sqrt(0.5);
  gltf.nodes.push_back({{"name", "patient"},
                        {"rotation", {-half, 0.0, 0.0, half}},
                        {"scale", {0.001, 0.001, 0.001}},
                        {"children", objects}});
  Json json;
  json["asset"] = {{"version", "2.0"},
                   {"generator", "SimplexSeg " SIMPLEXSEG_VERSION},
                   {"extras", {{"coordinates", std::string(mesh_frame) + " below the node patient"}}}};
  json["scene"] = 0;
  json["scenes"] = Json::array({{{"nodes", Json::array({gltf.nodes.size() - 1})}}});
  json["nodes"] = gltf.nodes, json["meshes"] = gltf.meshes, json["materials"] = gltf.materials;
  json["accessors"] = gltf.accessors, json["bufferViews"] = gltf.views;
  json["buffers"] = Json::array({{{"byteLength", gltf.binary.size()}}});
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  const std::size_t bytes = 12 + 8 + (text.size() + 3) / 4 * 4 + 8 + (gltf.binary.size() + 3) / 4 * 4;
  if (bytes > std::numeric_limits<std::uint32_t>::max())
    throw Error("cannot write glTF", "the surfaces exceed 4 GiB", "write fewer or coarser surfaces");
  std::string file;
  file.reserve(bytes);
  append(file, kMagic), append(file, kVersion), append(file, static_cast<std::uint32_t>(bytes));
  append_chunk(file, kJsonChunk, text, ' ');
  append_chunk(file, kBinaryChunk, gltf.binary, '\0');
  return file;
}

}  // namespace simplexseg
