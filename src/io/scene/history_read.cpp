// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <tuple>

#include "core/error.h"
#include "image/volume.h"
#include "io/mesh/ply.h"
#include "io/platform/cbor.h"
#include "io/platform/files.h"
#include "io/scene/history_format.h"
#include "io/scene/history_io.h"
#include "io/scene/json_input.h"
#include "io/scene/log_io.h"
#include "io/scene/mesh_start.h"
#include "io/scene/point_text.h"
#include "io/scene/scene_text.h"
#include "session/scene_checks.h"

namespace simplexseg {
namespace fs = std::filesystem;
using nlohmann::json;
using namespace history;

namespace {

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 30;
constexpr std::size_t kMaxTextBytes = std::size_t{16} << 20;     // JSON text of one scene
constexpr std::size_t kMaxPaintedVoxels = std::size_t{1} << 29;  // in the boxes of all sets
constexpr std::size_t kMaxHeadItems = 4'000'000;
constexpr std::int64_t kMaxId = 1'000'000'000;

std::uint64_t number_at(Bytes bytes, std::size_t at, int length) {
  std::uint64_t value = 0;
  for (int byte = 0; byte < length; ++byte) value = value << 8 | bytes[at + static_cast<std::size_t>(byte)];
  return value;
}

/// Head and blocks of a file, in this order. Throws std::out_of_range if the checksum is wrong or the file is damaged.
std::vector<Bytes> parts_of(Bytes file) {
  expect(file.size() >= kBeforeHead + kCrcBytes && file[0] == kListHead && file[5] == kMagicHead &&
             std::memcmp(&file[6], kMagic.data(), kMagic.size()) == 0,
         "it is not an undo history");
  const std::size_t end = file.size() - kCrcBytes;
  expect(file[end] == kNumberHead && number_at(file, end + 1, 4) == crc32_z(0, file.data(), end),
         "it is incomplete or damaged");
  std::vector<Bytes> parts;
  for (std::size_t at = kBeforeHead; at < end;) {
    expect(end - at >= 9 && file[at] == kBytesHead, "it is damaged");
    const std::uint64_t size = number_at(file, at + 1, 8);
    at += 9;
    expect(size <= end - at, "it is damaged");
    parts.push_back(file.subspan(at, size));
    at += size;
  }
  expect(!parts.empty() && number_at(file, 1, 4) == parts.size() + 2, "it is damaged");
  return parts;
}

/// Reader of the history of one scene. Throws std::out_of_range, Error or a JSON exception for an invalid history.
class HistoryReader {
 public:
  HistoryReader(const fs::path& file, const Scene& present, const Volume& volume)
      : place_(quoted(file)), folder_(file.parent_path()), present_(present), volume_(volume) {}

  UndoHistory read(Bytes file) {
    parts_ = parts_of(file);
    const std::string bytes(parts_[0].begin(), parts_[0].end());
    expect_plain_cbor(bytes, kMaxHeadItems);
    const json head = json::from_cbor(bytes);
    expect(head.at("simplexseg_history").get<int>() == kVersion, "its version is not supported");
    expect(head.at("scene") == owner_json<json>(present_), "it belongs to another scene");
    const auto volume = head.at("volume").get<std::string>();
    expect(volume.empty() || volume == present_.volume_checksum, "it belongs to another volume");
    UndoHistory::Entries undo = read_entries(head.at("undo")), redo = read_entries(head.at("redo"));
    return UndoHistory(std::move(undo), std::move(redo));
  }

 private:
  UndoHistory::Entries read_entries(const json& saved) {
    expect(saved.size() <= UndoHistory::kMaxSteps, "it has too many steps");
    UndoHistory::Entries entries;
    for (const json& entry : saved)
      entries.push_back(
          std::make_shared<const UndoHistory::Entry>(read_entry(entry, entries.empty() ? nullptr : entries.back())));
    return entries;
  }

  UndoHistory::Entry read_entry(const json& saved, const std::shared_ptr<const UndoHistory::Entry>& before) {
    const auto& text = saved.at("scene").get_ref<const std::string&>();
    expect(text.size() <= kMaxTextBytes, "a scene in it is too large");
    const JsonInput input = JsonInput::of_text(text, place_, "scene");
    std::size_t m = 0;
    const json &meshes = saved.at("meshes"), &points = saved.at("points");
    Scene scene =
        scene_of(input, folder_, [&](const JsonInput& mesh, MeshItem& item) { read_mesh(meshes.at(m++), mesh, item); });
    expect(meshes.size() == scene.meshes.size() && points.size() == scene.points.size(),
           "a scene in it has a different number of meshes or points");
    scene.volume_path = present_.volume_path, scene.volume_number = present_.volume_number;
    scene.volume_checksum = present_.volume_checksum, scene.volume_series = present_.volume_series;
    std::map<ItemId, ItemId> ids;
    for (std::size_t k = 0; k < scene.meshes.size(); ++k) {
      ItemId& id = scene.meshes[k].id;
      id = ids[id] = id_of(meshes[k].at("id"));
    }
    for (std::size_t k = 0; k < scene.points.size(); ++k)
      scene.points[k].mesh = ids.at(scene.points[k].mesh), scene.points[k].id = id_of(points[k]);
    if (saved.contains("voxels"))
      for (const json& pair : saved.at("voxels")) {
        const auto point = pair.at(0).get<std::size_t>();
        expect(point < scene.points.size() && !scene.points[point].voxels, "its painted voxels belong to no point");
        UserPoint& paint = scene.points[point];
        paint.voxels = painted_voxels(pair.at(1)), paint.brush = {PaintBrush::Shape::Voxels};
      }
    const json measurements = saved.value("measurements", json::array());  // absent without measurements
    expect(measurements.size() == scene.measurements.size(), "a scene in it has a different number of measurements");
    for (std::size_t k = 0; k < scene.measurements.size(); ++k) scene.measurements[k].id = id_of(measurements[k]);
    const json layers = saved.value("layers", json::array());  // absent without layers
    expect(layers.size() == scene.layers.size(), "a scene in it has a different number of layers");
    ids = {{0, 0}};
    for (std::size_t k = 0; k < scene.layers.size(); ++k) {
      ItemId& id = scene.layers[k].id;
      id = ids[id] = id_of(layers[k]);
    }
    for (MeshItem& item : scene.meshes) {
      item.images.main = ids.at(item.images.main);
      for (ItemId& id : item.images.further) id = ids.at(id);
    }
    check_scene(scene, volume_);
    std::set<std::size_t> used;
    std::vector<Arrays> arrays;
    for (const json& mesh : meshes) arrays.push_back(read_arrays(mesh, used));
    const JsonInput command = JsonInput::of_text(saved.at("command").get_ref<const std::string&>(), place_, "command");
    return {SceneSnapshot(std::move(scene), std::move(arrays), before ? &before->scene : nullptr),
            read_command(command), one_line(saved.at("name").get<std::string>())};
  }

  static ItemId id_of(const json& saved) {
    const auto id = saved.get<std::int64_t>();
    expect(id > 0 && id <= kMaxId, "an id is out of range");
    return static_cast<ItemId>(id);
  }

  void read_mesh(const json& saved, const JsonInput& input, MeshItem& item) {
    const auto& state = saved.at("state").get_binary();
    restore_pose_state(place_, std::string(state.begin(), state.end()), item);
    item.edge_mm = saved.at("edge_mm").get<float>();
    expect(std::isfinite(item.edge_mm), "a mean edge length is not finite");
    if (saved.contains("field")) item.field = field(saved.at("field"));
    if (saved.contains("field_settled"))
      item.fit = {item.field, saved.at("field_disagreement").get<int>(), saved.at("field_settled").get<bool>()};
    expect(input.has("start") == saved.contains("start"), "the start of a mesh in it is missing");
    if (!input.has("start")) return;
    item.start = mesh_start_from_json(input["start"]);
    if (!item.start->network) item.start->path = absolute_if_found(item.start->path, folder_);
    item.start->mesh = start_mesh(saved.at("start"));
  }

  Arrays read_arrays(const json& saved, std::set<std::size_t>& used) {
    // Meshes must not share an array: a small file could otherwise describe a scene of any size.
    for (const char* key : {"positions", "neighbours", "previous", "shape", "profiles"}) {
      const std::size_t number = number_of(saved.at(key));
      expect(number == 0 || used.insert(number).second, "an array in it belongs to several meshes");
    }
    return {block<Eigen::Vector3f>(saved.at("positions")), block<std::array<int, 3>>(saved.at("neighbours")),
            block<std::uint8_t>(saved.at("previous")), block<Vec4>(saved.at("shape")),
            block<float>(saved.at("profiles"))};
  }

  std::size_t number_of(const json& saved) const {
    const auto number = saved.get<std::int64_t>();
    expect(number >= 0 && static_cast<std::size_t>(number) < parts_.size(), "an array is missing");
    return static_cast<std::size_t>(number);
  }

  template <class T>
  Block<T> block(const json& saved) {
    const std::size_t number = number_of(saved);
    Block<T>& cached = std::get<std::map<std::size_t, Block<T>>>(blocks_)[number];
    if (cached) return cached;
    const Bytes bytes = number == 0 ? Bytes() : parts_[number];
    expect(bytes.size() % sizeof(T) == 0, "the length of an array is invalid");
    std::vector<T> values(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
    return cached = std::make_shared<const std::vector<T>>(std::move(values));
  }

  std::string text_of_block(const json& saved) const {
    const std::size_t number = number_of(saved);
    expect(number > 0, "an array is missing");
    return {parts_[number].begin(), parts_[number].end()};
  }

  std::shared_ptr<const MeshField> field(const json& saved) {
    std::shared_ptr<const MeshField>& cached = fields_[number_of(saved)];
    if (cached) return cached;
    cached = field_from_bytes(text_of_block(saved));
    expect(cached->values.empty() || (!volume_.empty() && cached->box.lies_in(volume_.geometry().size)),
           "a field lies outside the volume");
    return cached;
  }

  std::shared_ptr<const PaintVoxels> painted_voxels(const json& saved) {
    std::shared_ptr<const PaintVoxels>& cached = voxels_[number_of(saved)];
    if (cached) return cached;
    cached = read_voxels(JsonInput::of_text(text_of_block(saved), place_, "paint"));
    painted_count_ += cached->voxels.size();
    expect(painted_count_ <= kMaxPaintedVoxels, "its sets of painted voxels are too large");
    return cached;
  }

  std::shared_ptr<const SimplexMesh> start_mesh(const json& saved) {
    std::shared_ptr<const SimplexMesh>& cached = starts_[number_of(saved)];
    if (cached) return cached;
    SimplexMesh mesh = mesh_of_ply(text_of_block(saved), place_);
    validate(mesh);
    return cached = std::make_shared<const SimplexMesh>(std::move(mesh));
  }

  const std::string place_;
  const fs::path folder_;
  const Scene& present_;
  const Volume& volume_;
  std::vector<Bytes> parts_;
  std::tuple<std::map<std::size_t, Block<Eigen::Vector3f>>, std::map<std::size_t, Block<std::array<int, 3>>>,
             std::map<std::size_t, Block<std::uint8_t>>, std::map<std::size_t, Block<Vec4>>,
             std::map<std::size_t, Block<float>>>
      blocks_;
  std::map<std::size_t, std::shared_ptr<const MeshField>> fields_;
  std::map<std::size_t, std::shared_ptr<const PaintVoxels>> voxels_;
  std::size_t painted_count_ = 0;  ///< voxels of all boxes in `voxels_`
  std::map<std::size_t, std::shared_ptr<const SimplexMesh>> starts_;
};

}  // namespace

UndoHistory read_history(const fs::path& scene_file, const Scene& scene, const Volume& volume) {
  const fs::path path = history_path(scene_file);
  std::error_code failure;
  if (!fs::exists(path, failure)) return UndoHistory();
  const auto error_for = [&path](const std::string& why) -> Error {
    return Error("cannot restore the undo history " + quoted(path), one_line(why), "save the scene to replace it");
  };
  try {
    require_file(path);
    if (fs::file_size(path, failure) > kMaxFileBytes) throw std::out_of_range("it is too large");
    const std::string bytes = read_bytes(path);
    return HistoryReader(path, scene, volume).read({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  } catch (const json::exception&) {
    throw error_for("it is damaged");
  } catch (const std::exception& error) {
    throw error_for(error.what());
  }
}

}  // namespace simplexseg
