// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <list>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>

#include "io/mesh/ply.h"
#include "io/platform/atomic_file.h"
#include "io/scene/history_format.h"
#include "io/scene/history_io.h"
#include "io/scene/json_output.h"
#include "io/scene/log_io.h"
#include "io/scene/scene_text.h"

namespace simplexseg {
namespace fs = std::filesystem;
using nlohmann::json;
using namespace history;

namespace {

template <class T>
Bytes bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)};
}
Bytes bytes_of(const std::string& text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

/// Calls `visit` for each array of a mesh.
template <class Visit>
void for_each_block(const Arrays& arrays, const Visit& visit) {
  visit(arrays.positions), visit(arrays.neighbours), visit(arrays.previous), visit(arrays.shape),
      visit(arrays.profiles);
}

/// Numbers of undo and redo steps to save: the steps nearest to the present whose arrays together fit into `max_bytes`.
std::pair<std::size_t, std::size_t> nearest_steps(const UndoHistory& history, std::size_t max_bytes) {
  std::set<const void*> seen;
  std::size_t bytes = 0;
  const auto count = [&](const auto& shared, std::size_t size) {
    if (shared && seen.insert(shared.get()).second) bytes += size;
  };
  const auto fits = [&](const UndoHistory::Entry& entry) {
    for (const Arrays& arrays : entry.scene.arrays())
      for_each_block(arrays, [&](const auto& block) { count(block, bytes_of(*block).size()); });
    for (const UserPoint& point : entry.scene.without_arrays().points)
      if (point.voxels) count(point.voxels, point.voxels->voxels.size() / 8);
    for (const MeshItem& item : entry.scene.without_arrays().meshes) {
      if (item.field) count(item.field, bytes_of(item.field->values).size());
      if (item.start) count(item.start->mesh, bytes_of(item.start->mesh->positions).size() * 2);
    }
    return bytes <= max_bytes;
  };
  const UndoHistory::Entries &undo = history.to_undo(), &redo = history.to_redo();
  std::size_t undone = 0, redone = 0;
  for (std::size_t step = 0; step < std::max(undo.size(), redo.size()); ++step) {
    if (step < undo.size()) {
      if (!fits(*undo[undo.size() - 1 - step])) break;
      ++undone;
    }
    if (step < redo.size()) {
      if (!fits(*redo[redo.size() - 1 - step])) break;
      ++redone;
    }
  }
  return {undone, redone};
}

/// Maps ids to those that the scene gets when it is read again: its meshes, points, measurements and layers in order,
/// then all other ids.
class IdMap {
 public:
  explicit IdMap(const Scene& present) {
    for (const MeshItem& item : present.meshes) (*this)(item.id);
    for (const UserPoint& point : present.points) (*this)(point.id);
    for (const Measurement& measurement : present.measurements) (*this)(measurement.id);
    for (const LayerItem& layer : present.layers) (*this)(layer.id);
  }
  ItemId operator()(ItemId id) {
    if (id == 0) return 0;
    const auto [at, fresh] = ids_.try_emplace(id, next_);
    if (fresh) ++next_;
    return at->second;
  }
  Command operator()(Command command) {
    std::visit(
        [this](auto& c) {
          if constexpr (requires { c.mesh; }) c.mesh = (*this)(c.mesh);
          if constexpr (requires { c.point; }) c.point = (*this)(c.point);
          if constexpr (requires { c.measurement; }) c.measurement = (*this)(c.measurement);
          if constexpr (requires { c.layer; }) c.layer = (*this)(c.layer);
          if constexpr (requires { c.like; }) c.like = (*this)(c.like);
          if constexpr (requires { c.other; }) c.other = (*this)(c.other);
          if constexpr (requires { c.images; }) {
            c.images.main = (*this)(c.images.main);
            for (ItemId& id : c.images.further) id = (*this)(id);
          }
        },
        command);
    return command;
  }

 private:
  std::map<ItemId, ItemId> ids_;
  ItemId next_ = 1;
};

/// Blocks of a file, numbered from 1. Shared arrays are stored once; number 0 is an empty array.
class BlockTable {
 public:
  template <class T>
  std::size_t number_of(const Block<T>& block) {
    return block->empty() ? 0 : number_of(block.get(), [&] { return bytes_of(*block); });
  }
  std::size_t number_of(const std::shared_ptr<const MeshField>& field) {
    const MeshField* const solved = field->solved ? field->solved.get() : field.get();  // paint is added again
    return number_of(solved, [&] { return bytes_of(made_.emplace_back(field_bytes(*solved))); });
  }
  std::size_t number_of(const std::shared_ptr<const SimplexMesh>& mesh) {
    return number_of(mesh.get(), [&] { return bytes_of(made_.emplace_back(ply_of(*mesh))); });
  }
  std::size_t number_of(const std::shared_ptr<const PaintVoxels>& voxels) {
    return number_of(voxels.get(), [&] { return bytes_of(made_.emplace_back(voxels_json<json>(*voxels).dump())); });
  }
  const std::vector<Bytes>& blocks() const { return blocks_; }

 private:
  template <class Make>
  std::size_t number_of(const void* what, const Make& make) {
    const auto [at, fresh] = numbers_.try_emplace(what, blocks_.size() + 1);
    if (fresh) blocks_.push_back(make());
    return at->second;
  }

  std::map<const void*, std::size_t> numbers_;
  std::vector<Bytes> blocks_;
  std::list<std::string> made_;
};

json binary(Bytes bytes) { return json::binary({bytes.begin(), bytes.end()}); }

json mesh_json(const MeshItem& item, const Arrays& arrays, IdMap& ids, BlockTable& blocks) {
  MeshItem rest = item;
  rest.field = nullptr, rest.fit = {};
  json saved = {{"id", ids(item.id)},
                {"positions", blocks.number_of(arrays.positions)},
                {"neighbours", blocks.number_of(arrays.neighbours)},
                {"previous", blocks.number_of(arrays.previous)},
                {"shape", blocks.number_of(arrays.shape)},
                {"profiles", blocks.number_of(arrays.profiles)},
                {"edge_mm", item.edge_mm},
                {"state", binary(bytes_of(pose_state_bytes(rest)))}};
  if (item.start) saved["start"] = blocks.number_of(item.start->mesh);
  if (!item.field) return saved;
  saved["field"] = blocks.number_of(item.field);
  if (item.fit.field == item.field)
    saved["field_disagreement"] = item.fit.disagreement, saved["field_settled"] = item.fit.settled;
  return saved;
}

json entry_json(const UndoHistory::Entry& entry, const fs::path& scene_file, IdMap& ids, BlockTable& blocks) {
  Scene scene = entry.scene.without_arrays();
  // All scenes of a history have the same volume, which is not stored.
  scene.volume_path.clear(), scene.volume_checksum.clear(), scene.volume_series.clear(), scene.volume_number = 1;
  json voxels = json::array();  // sets of voxels, stored once for all scenes: index of the point, number of the block
  for (std::size_t p = 0; p < scene.points.size(); ++p) {
    UserPoint& point = scene.points[p];
    if (!point.voxels) continue;
    voxels.push_back({p, blocks.number_of(point.voxels)});
    point.voxels = nullptr, point.brush = PaintBrush::ball();
  }
  json saved = {{"name", entry.name},
                {"voxels", voxels},
                {"command", command_text(ids(entry.command))},
                {"scene", scene_text(scene_file, scene, {}, -1)},
                {"meshes", json::array()},
                {"points", json::array()}};
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    saved["meshes"].push_back(mesh_json(scene.meshes[m], entry.scene.arrays()[m], ids, blocks));
  for (const UserPoint& point : scene.points) saved["points"].push_back(ids(point.id));
  for (const Measurement& measurement : scene.measurements) saved["measurements"].push_back(ids(measurement.id));
  for (const LayerItem& layer : scene.layers) saved["layers"].push_back(ids(layer.id));
  return saved;
}

/// Writes to a file and computes the CRC-32 of the written bytes.
class ChecksummedFile {
 public:
  explicit ChecksummedFile(AtomicFile& file) : file_(file) {}
  void write(Bytes bytes) {
    crc_ = crc32_z(crc_, bytes.data(), bytes.size());
    file_.write(bytes.data(), bytes.size());
  }
  void write_head(std::uint8_t head, std::uint64_t value, int length) {
    std::vector<std::uint8_t> bytes{head};
    for (int byte = length - 1; byte >= 0; --byte) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * byte)));
    write(bytes);
  }
  void write_block(Bytes bytes) { write_head(kBytesHead, bytes.size(), 8), write(bytes); }
  void write_crc() { write_head(kNumberHead, crc_, 4); }

 private:
  AtomicFile& file_;
  uLong crc_ = crc32_z(0, nullptr, 0);
};

}  // namespace

fs::path history_path(const fs::path& scene_file) { return fs::path(scene_file).replace_extension(".history"); }

void write_history(AtomicFile& file, const fs::path& scene_file, const Scene& scene, const UndoHistory& history,
                   std::size_t max_bytes) {
  IdMap ids(scene);
  BlockTable blocks;
  const auto [undone, redone] = nearest_steps(history, max_bytes);
  const auto entries_json = [&](std::span<const std::shared_ptr<const UndoHistory::Entry>> entries) {
    json saved = json::array();
    for (const auto& entry : entries) saved.push_back(entry_json(*entry, scene_file, ids, blocks));
    return saved;
  };
  const json head = {{"simplexseg_history", kVersion},
                     {"scene", owner_json<json>(scene)},
                     {"volume", scene.volume_checksum},
                     {"undo", entries_json(std::span(history.to_undo()).last(undone))},
                     {"redo", entries_json(std::span(history.to_redo()).last(redone))}};
  ChecksummedFile output(file);
  output.write_head(kListHead, blocks.blocks().size() + 3, 4);
  output.write_head(kMagicHead, 0, 0);
  output.write(bytes_of(std::string(kMagic)));
  output.write_block(json::to_cbor(head));
  for (const Bytes& block : blocks.blocks()) output.write_block(block);
  output.write_crc();
}

void remove_history(const fs::path& scene_file) {
  const fs::path path = history_path(scene_file);
  std::error_code failure;
  if (!fs::is_regular_file(path, failure)) return;
  std::ifstream file(path, std::ios::binary);
  std::string start(kBeforeHead, '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  if (start[0] == static_cast<char>(kListHead) && start.ends_with(kMagic)) fs::remove(path, failure);
}

}  // namespace simplexseg
