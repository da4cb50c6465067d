// SPDX-License-Identifier: Apache-2.0
// Undo history saved beside a scene: restored bit for bit, or ignored with a warning that states the reason.
#include "io/scene/history_io.h"

#include <zlib.h>

#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "../session/session_fixture.h"
#include "forces/force_list.h"
#include "io/labels/labels_io.h"
#include "io/scene/load_input.h"
#include "io/scene/mesh_start.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"
#include "test_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::error_of;

/// States of a session at the present, after each undo back to the first, and after each redo to the last.
std::vector<SessionState> all_states(Session& session) {
  std::vector<SessionState> states{state_of(session)};
  while (session.can_undo()) session.apply(Undo{}), states.push_back(state_of(session));
  while (session.can_redo()) session.apply(Redo{}), states.push_back(state_of(session));
  return states;
}

/// Numbers the ids in order of appearance, since ids are renumbered when a scene is read.
std::vector<SessionState> with_plain_ids(std::vector<SessionState> states) {
  std::map<ItemId, ItemId> ids;
  const auto plain = [&ids](ItemId& id) {
    id = ids.try_emplace(id, static_cast<ItemId>(ids.size() + 1)).first->second;
  };
  for (SessionState& state : states) {
    for (MeshItem& item : state.scene.meshes) plain(item.id);
    for (UserPoint& point : state.scene.points) plain(point.id), plain(point.mesh);
    for (Measurement& measurement : state.scene.measurements) plain(measurement.id);
    for (LayerItem& layer : state.scene.layers) plain(layer.id);
  }
  return states;
}

class HistoryIo : public test::FolderTest {
 protected:
  HistoryIo() { write_volume(folder / "image.nii", phantom("sphere", 100, 10).image); }

  fs::path scene_file() const { return folder / "scene.json"; }
  fs::path history_file() const { return folder / "scene.history"; }

  std::unique_ptr<Session> open(LoadedInput input) const {
    auto session = std::make_unique<Session>(make_cpu_engine(1), nullptr, 1);
    session->open(std::move(input.scene), std::move(input.volume), std::move(input.history));
    return session;
  }
  std::unique_ptr<Session> open_ball() const {
    LoadedInput input = load_input(folder / "image.nii");
    const std::string path = input.scene.volume_path, checksum = input.scene.volume_checksum;
    input.scene = ball_scene();
    input.scene.volume_path = path, input.scene.volume_checksum = checksum;
    return open(std::move(input));
  }
  void save(const Session& session) const { write_scene(scene_file(), session.scene(), session.history()); }
  /// Saves a session with a few actions, as input for damaged histories.
  std::unique_ptr<Session> save_a_few() const {
    auto session = open_ball();
    const ItemId ball = session->scene().meshes[0].id;
    session->apply(AddPoint{ball, {0, 0, 18}});
    session->advance_steps(3);
    session->apply(EditMesh{ball, "kidney", {}, {}, {}});
    session->apply(AddMesh{"other", {{3, 3, 3}, 8}, {}, 0});
    session->apply(Undo{});
    save(*session);
    return session;
  }
  /// The only warning when the scene is opened; empty if there is none.
  std::string warning() const {
    const LoadedInput input = load_input(scene_file());
    EXPECT_LE(input.warnings.size(), 1u);
    if (input.warnings.empty()) return {};
    const std::string& line = input.warnings[0];
    EXPECT_EQ(line.find_first_of("\n\r\t"), std::string::npos) << line;
    EXPECT_HAS(line, "scene.history");
    EXPECT_HAS(line, "cannot restore the undo history");
    EXPECT_FALSE(input.history.can_undo() || input.history.can_redo());
    EXPECT_EQ(input.scene.meshes.size(), 1u);
    return line;
  }
};

/// Replaces the checksum at the end by the correct one.
std::string with_checksum(std::string bytes) {
  if (bytes.size() < 5) return bytes;
  const std::size_t end = bytes.size() - 5;
  const auto crc = crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes.data()), end);
  bytes[end] = '\x1a';
  for (int byte = 0; byte < 4; ++byte)
    bytes[end + 1 + static_cast<std::size_t>(byte)] = static_cast<char>(crc >> (24 - 8 * byte));
  return bytes;
}

TEST_F(HistoryIo, ThirtyMixedActionsAreRestoredBitForBit) {
  const auto session = open_ball();
  const ItemId ball = session->scene().meshes[0].id;
  const auto run = [&](int steps) { session->advance_steps(steps); };
  session->apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::source, 0});  // fields
  run(6);
  ASSERT_TRUE(session->scene().meshes[0].has_field());
  const ItemId pull = session->apply(AddPoint{ball, {0, 0, 18}});
  for (int k = 1; k <= 5; ++k) session->apply(MovePoint{pull, {0, 0.5 * k, 18}, true}), run(2);
  const ItemId inside = session->apply(AddPoint{ball, {1, 0, 2}, MarkKind::Inside, 2});
  run(4);
  session->apply(AddPoint{ball, {17.5, 0, 0}, MarkKind::Outside});
  run(4);
  session->apply(AddPoint{ball, {0, 20, 0}, MarkKind::Inside, 3, {0, 0, 0}, {{3, 0, 0}}, PaintBrush::ball()});
  ASSERT_EQ(session->scene().meshes[0].field->paint.size(), 1u);
  run(2);
  session->apply(EditVoxels{ball, VoxelEdit::Margin, 1.5});
  session->apply(
      AddPoint{ball, {18, 0, 0}, MarkKind::Inside, 4, {0, 0, 0}, {{0, 3, 0}}, PaintBrush::ball(), VoxelEdit::Freeze});
  run(2);
  const ItemId lasso = session->apply(
      AddLasso{ball, MarkKind::Outside, {{25, 25, 1}, {29, 25, 1}, {29, 29, 1}, {25, 29, 1}}, {0, 0, 1}});
  session->apply(MovePoint{lasso, {25.5, 25, 1}});
  const ItemId ruler = session->apply(AddMeasurement{MeasurementKind::Ruler, {{0, 0, 0}, {1.0 / 3, 4, 0}}, ""});
  session->apply(AddMeasurement{MeasurementKind::Ellipse, {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, "Ö"});
  for (int k = 1; k <= 3; ++k) session->apply(MoveMeasurement{ruler, {{0, 0, 0}, {5.0 / k, 4, 0}}, k > 1});
  session->apply(DeleteMeasurement{ruler});
  run(1);
  for (const float value : {0.2f, 0.3f, 0.4f}) {
    session->apply(SetForceParameter{ball, ForceId::Smoothing, 0, value, value > 0.2f});
    run(1);
  }
  session->apply(ResizePoint{inside, 3.5});
  session->apply(ResizePoint{inside, 4.5, true});
  const ItemId other = session->apply(AddMesh{"other", {{3, 3, 3}, 8}, Colour{1, 2, 3}, ball});
  run(5);
  session->apply(AddPoint{other, {3, 3, 12}, MarkKind::Boundary, 0, {0, 0, 1}});
  session->apply(EditMesh{
      other, "Ångström", {}, false, 9, {}, 0.25f, SegmentCode{{"SCT", "85756007", "Tissue"}, {"99X", "1", "Å"}, {}}});
  session->apply(RecordProfiles{other});
  session->apply(RefineMesh{other});
  run(3);
  session->apply(SetReference{other, Reference{"truth.nii.gz", 3}});
  const ItemId copy = session->apply(DuplicateMesh{other});
  run(2);
  session->apply(ReorderMesh{copy, 0});
  write_labels(folder / "labels.nii.gz", phantom("sphere", 100, 10).labels);
  const LoadedStart start = load_start({(folder / "labels.nii.gz").string(), 1.0, 1, nullptr}, folder);
  const ItemId of_labels = session->apply(AddMesh{"of labels", start.seed, {}, 0, start.start});
  run(3);
  session->apply(EditMesh{of_labels, {}, {}, {}, {}, true});
  session->apply(SetSimulationParameter{simulation_index("damping"), 0.75f});
  session->apply(SetParameters{copy, default_force_parameters(), default_simulation_parameters()});
  run(4);
  session->apply(DeletePoint{pull});
  session->apply(DeleteMesh{other});
  run(3);
  session->apply(ResetPose{ball});
  run(5);
  session->apply(MovePoint{inside, {2, 0, 2}});
  for (int n = 0; n < 7; ++n) session->apply(Undo{}), run(1);
  ASSERT_EQ(session->history().redo_names().size(), 7u);
  ASSERT_GE(session->log().size(), 30u);
  save(*session);

  const LoadedInput loaded = load_input(scene_file());
  for (const std::string& line : loaded.warnings) EXPECT_HAS(line, "truth.nii.gz");  // that file is missing
  const auto again = open(loaded);
  EXPECT_EQ(again->history().undo_names(), session->history().undo_names());
  EXPECT_EQ(again->history().redo_names(), session->history().redo_names());
  EXPECT_STREQ(again->undo_title(), session->undo_title());
  EXPECT_STREQ(again->redo_title(), session->redo_title());
  EXPECT_FALSE(again->scene().points.empty());
  const std::size_t undone = session->history().undo_names().size();
  auto wanted = with_plain_ids(all_states(*session));
  const auto got = with_plain_ids(all_states(*again));
  ASSERT_EQ(wanted.size(), got.size());
  for (std::size_t n = 0; n < wanted.size(); ++n) {
    // The mean edge length of a scene that was read is computed from its pose; those of the history are restored.
    for (std::size_t m = 0; m < wanted[n].scene.meshes.size() && n % (2 * undone) == 0; ++m)
      wanted[n].scene.meshes[m].edge_mm = got[n].scene.meshes[m].edge_mm;
    EXPECT_TRUE(same_state(got[n], wanted[n])) << n;
    for (std::size_t m = 0; m < wanted[n].scene.meshes.size(); ++m) {
      const MeshItem &a = got[n].scene.meshes[m], &b = wanted[n].scene.meshes[m];
      EXPECT_EQ(a.reference.has_value(), b.reference.has_value());
      ASSERT_EQ(a.start.has_value(), b.start.has_value());
      if (b.start) {
        EXPECT_EQ(a.start->mesh->positions, b.start->mesh->positions);
        EXPECT_EQ(a.start->value, b.start->value);
      }
      ASSERT_EQ(a.has_field(), b.has_field());
      if (b.field) {
        EXPECT_EQ(a.field->marks.size(), b.field->marks.size());
      }
    }
  }
  // The history continues normally: an action clears the redo steps, and undo restores the previous state bit for bit.
  again->apply(Undo{});
  EXPECT_TRUE(again->can_redo());
  const SessionState before = state_of(*again);
  again->apply(AddPoint{again->scene().meshes[0].id, {0, 5, 5}});
  EXPECT_FALSE(again->can_redo());
  again->advance_steps(9);
  again->apply(Undo{});
  EXPECT_TRUE(same_state(state_of(*again), before));
}

TEST_F(HistoryIo, SavingAgainGivesTheSameFile) {
  const auto session = save_a_few();
  auto again = open(load_input(scene_file()));
  const std::string once = bytes_of(history_file());
  save(*again);
  EXPECT_TRUE(bytes_of(history_file()) == once);
}

TEST_F(HistoryIo, ALogThatUndoesEarlierActionsCanBeReplayed) {
  save_a_few();
  const auto live = open(load_input(scene_file()));
  const ItemId added = live->apply(AddPoint{live->scene().meshes[0].id, {0, 12, 5}});
  live->advance_steps(4);
  live->apply(MovePoint{added, {0, 13, 5}});
  for (int n = 0; n < 3; ++n) live->apply(Undo{}), live->advance_steps(3);
  const auto replayed = open(load_input(scene_file()));
  replayed->replay(live->log(), live->steps_since_last_command());
  EXPECT_TRUE(same_state(state_of(*replayed), state_of(*live)));
}

/// Scene with a mesh whose position depends on `step`.
Scene moved(int step, int level) {
  Scene scene;
  scene.simulation = default_simulation_parameters();
  MeshItem& item = scene.meshes.emplace_back();
  item.id = 1, item.name = "kidney", item.seed.radius_mm = 5, item.parameters = default_force_parameters();
  item.mesh = make_sphere({0, 0, 0}, 20 + 0.01 * step, level);
  item.previous = make_sphere({0, 0, 0}, 20 + 0.01 * step - 0.003, level).positions;
  item.shape.assign(item.mesh.positions.size(), Vec4{1, 2, 3, static_cast<float>(level)});
  return scene;
}

UndoHistory history_of(int steps, int level) {
  UndoHistory history;
  for (int n = 0; n < steps; ++n) history.push({moved(n, level), MovePoint{1, {0, 0, static_cast<double>(n)}}});
  return history;
}

TEST_F(HistoryIo, TwoHundredStepsOf20kVerticesTakeAtMost100Megabytes) {
  constexpr int kSteps = 200, kLevel = 5;  // 20480 vertices
  UndoHistory history = history_of(kSteps, kLevel);
  Scene present = moved(kSteps, kLevel);
  write_scene(scene_file(), present, history);
  const auto bytes = fs::file_size(history_file());
  EXPECT_LE(bytes, 100'000'000u);
  UndoHistory read = read_history(scene_file(), present, Volume());
  RecordProperty("bytes", static_cast<int>(bytes));
  ASSERT_EQ(read.to_undo().size(), 200u);
  EXPECT_LE(read.bytes(), 100'000'000u);
  for (int n = kSteps - 1; n >= 0; --n) {
    ASSERT_TRUE(read.undo(present));
    if (n % 40 != 7) continue;
    EXPECT_EQ(present.meshes[0].mesh.positions, moved(n, kLevel).meshes[0].mesh.positions) << n;
    EXPECT_EQ(present.meshes[0].previous, moved(n, kLevel).meshes[0].previous) << n;
  }
}

TEST_F(HistoryIo, TheNearestStepsOfALongHistoryAreSaved) {
  UndoHistory history = history_of(40, 2);  // about 5 kB a step
  Scene present = moved(40, 2);
  for (int n = 0; n < 10; ++n) history.undo(present);
  write_scene(scene_file(), present, history, 60'000);
  EXPECT_LT(fs::file_size(history_file()), 250'000u);  // includes data other than arrays
  UndoHistory read = read_history(scene_file(), present, Volume());
  const std::size_t undo = read.to_undo().size(), redo = read.to_redo().size();
  EXPECT_GE(undo, 3u);
  EXPECT_LT(undo, 30u);
  EXPECT_TRUE(undo == redo || undo == redo + 1) << undo << " and " << redo;
  Scene there = present;
  ASSERT_TRUE(read.undo(there));
  EXPECT_EQ(there.meshes[0].mesh.positions, moved(29, 2).meshes[0].mesh.positions);
  ASSERT_TRUE(read.redo(there) && read.redo(there));
  EXPECT_EQ(there.meshes[0].mesh.positions, moved(31, 2).meshes[0].mesh.positions);
}

TEST_F(HistoryIo, SavingASceneWithoutAHistoryDeletesTheOldOne) {
  const auto session = save_a_few();
  ASSERT_TRUE(fs::exists(history_file()));
  write_scene(scene_file(), session->scene());
  EXPECT_FALSE(fs::exists(history_file()));
  EXPECT_EQ(warning(), "");
  // A file of another program with that name is not deleted.
  write("scene.history", "1 ls\n2 cd\n");
  write_scene(scene_file(), session->scene());
  EXPECT_EQ(bytes_of(history_file()), "1 ls\n2 cd\n");
  EXPECT_HAS(warning(), "not an undo history");
}

TEST_F(HistoryIo, AHistoryOfAnotherSceneOrVolumeIsIgnored) {
  const auto session = save_a_few();
  const std::string first = bytes_of(history_file());
  session->advance_steps(5);
  save(*session);
  const std::string second = bytes_of(history_file());
  EXPECT_EQ(warning(), "");
  write("scene.history", first);
  EXPECT_HAS(warning(), "another scene");
  write("scene.history", second);
  write_volume(folder / "image.nii", phantom("sphere", 100, 20).image);
  const std::vector<std::string> warnings = load_input(scene_file()).warnings;
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_HAS(warnings[0], "is not the image");
  EXPECT_HAS(warnings[1], "another volume");
}

TEST_F(HistoryIo, TruncatedAndDamagedHistoriesAreWarnings) {
  save_a_few();
  const std::string whole = bytes_of(history_file());
  EXPECT_EQ(warning(), "");
  for (std::size_t length = 0; length < whole.size(); length += 97) {
    write("scene.history", whole.substr(0, length));
    EXPECT_NE(warning(), "") << length;
  }
  write("scene.history", whole + "x");
  EXPECT_NE(warning(), "");
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    std::string bytes = whole;
    const std::size_t at = random() % bytes.size();
    bytes[at] = static_cast<char>(bytes[at] ^ static_cast<char>(1 << random() % 8));
    write("scene.history", bytes);
    EXPECT_NE(warning(), "") << at;
  }
}

/// A malicious file can have a correct checksum; its contents must be checked too.
TEST_F(HistoryIo, MaliciousHistoriesDoNoHarm) {
  save_a_few();
  const std::string whole = bytes_of(history_file());
  std::mt19937 random(4);
  int accepted = 0, rejected = 0;
  for (int round = 0; round < 800; ++round) {
    std::string bytes = whole;
    for (unsigned change = 0; change < 1 + random() % 3; ++change) {
      // Half of the changes are in the head, since the blocks are most of the file.
      const std::size_t at =
          random() % 2 ? random() % bytes.size() : random() % std::min<std::size_t>(bytes.size(), 9000);
      if (random() % 8 == 0)
        bytes.erase(at, 1 + random() % 8);
      else
        bytes[at] = random() % 2 ? static_cast<char>(random()) : "\0\xff\x7f\x80\x9f\x5f"[random() % 6];
    }
    write("scene.history", with_checksum(bytes));
    if (!warning().empty()) {
      ++rejected;
      continue;
    }
    ++accepted;
    const auto session = open(load_input(scene_file()));
    while (session->can_undo()) session->apply(Undo{});
    session->advance_steps(1);
    while (session->can_redo()) session->apply(Redo{});
    session->advance_steps(1);
  }
  EXPECT_GT(accepted, 20) << "a small change of a position cannot be detected";
  EXPECT_GT(rejected, 250);
}

constexpr std::size_t kHeadAt = 24, kHeadBytesAt = kHeadAt + 9;  // after the list, the text and the length

std::string head_of(const std::string& file) {
  std::size_t size = 0;
  for (std::size_t byte = 0; byte < 8; ++byte) size = size << 8 | static_cast<unsigned char>(file[kHeadAt + 1 + byte]);
  return file.substr(kHeadBytesAt, size);
}
/// Replaces the head of a file and corrects its checksum.
std::string with_head(const std::string& file, const std::string& head) {
  std::string bytes = file.substr(0, kHeadAt + 1);
  for (int byte = 7; byte >= 0; --byte) bytes += static_cast<char>(head.size() >> (8 * byte));
  return with_checksum(bytes + head + file.substr(kHeadBytesAt + head_of(file).size()));
}

TEST_F(HistoryIo, TheContentsOfTheHeadAreChecked) {
  Scene present = moved(9, 1);
  UndoHistory history;
  for (int n = 0; n < 3; ++n) {
    Scene before = moved(n, 1);
    before.meshes.push_back(moved(n + 5, 1).meshes[0]);
    before.meshes[1].id = 2, before.meshes[1].name = "other";
    before.points.push_back({3, 2, {0, 0, 0}});
    history.push({std::move(before), DeleteMesh{2}});
  }
  write_scene(scene_file(), present, history);
  const std::string whole = bytes_of(history_file());
  const auto head = nlohmann::json::from_cbor(head_of(whole));
  const auto error = [&](const std::function<void(nlohmann::json&)>& change) {
    nlohmann::json changed = head;
    change(changed);
    std::string bytes;
    nlohmann::json::to_cbor(changed, bytes);
    write("scene.history", with_head(whole, bytes));
    return error_of([&] { read_history(scene_file(), present, Volume()); });
  };
  write("scene.history", with_head(whole, head_of(whole)));
  EXPECT_EQ(read_history(scene_file(), present, Volume()).to_undo().size(), 3u);
  const auto mesh = [](nlohmann::json& head, int n) -> nlohmann::json& { return head["undo"][0]["meshes"][n]; };
  EXPECT_HAS(error([](auto& h) { h["simplexseg_history"] = 2; }), "version is not supported");
  EXPECT_HAS(error([&](auto& h) { mesh(h, 1)["positions"] = mesh(h, 0)["positions"]; }), "several meshes");
  EXPECT_HAS(error([&](auto& h) { mesh(h, 1)["positions"] = 900; }), "an array is missing");
  EXPECT_HAS(error([&](auto& h) { mesh(h, 1)["positions"] = 0; }), "no vertices");
  EXPECT_HAS(error([&](auto& h) { mesh(h, 1)["neighbours"] = 0; }), "neighbours for another number");
  EXPECT_HAS(error([&](auto& h) { mesh(h, 1)["shape"] = 0; }), "shape");
  EXPECT_HAS(error([&](auto& h) { std::swap(mesh(h, 1)["previous"], mesh(h, 1)["shape"]); }), "");
  EXPECT_HAS(error([&](auto& h) { mesh(h, 1)["id"] = mesh(h, 0)["id"]; }), "used twice");
  EXPECT_HAS(error([&](auto& h) { mesh(h, 1)["id"] = -1; }), "out of range");
  EXPECT_HAS(error([&](auto& h) { mesh(h, 1)["start"] = 1; }), "the start of a mesh in it is missing");
  EXPECT_HAS(error([&](auto& h) { mesh(h, 1).erase("state"); }), "damaged");
  EXPECT_HAS(error([&](auto& h) { mesh(h, 1)["field"] = 1; }), "cannot restore");
  EXPECT_HAS(error([](auto& h) { h["undo"][0]["points"].push_back(7); }), "number of meshes or points");
  EXPECT_HAS(error([](auto& h) { h["undo"][0]["meshes"].push_back(h["undo"][0]["meshes"][0]); }), "number of meshes");
  EXPECT_HAS(error([](auto& h) { h["undo"][0]["scene"] = R"({"simplexseg_scene": 1, "meshes": 3})"; }), "meshes");
  EXPECT_HAS(error([](auto& h) { h["undo"][0]["command"] = R"({"command": "dance"})"; }), "dance");
  EXPECT_HAS(error([](auto& h) {
               for (int n = 0; n < 200; ++n) h["redo"].push_back(h["undo"][0]);
               h["redo"].push_back(h["undo"][0]);
             }),
             "too many steps");
}

TEST_F(HistoryIo, HugeAndDeeplyNestedHistoriesAreRejected) {
  save_a_few();
  const std::string whole = bytes_of(history_file());
  std::error_code error;
  fs::resize_file(history_file(), std::uintmax_t{3} << 30, error);
  if (!error) {
    EXPECT_HAS(warning(), "too large");
  }
  // Lists nested a million times, texts without an end, and similar input.
  write("scene.history", with_head(whole, std::string(1'000'000, '\x81')));
  EXPECT_HAS(warning(), "nested");
  write("scene.history", with_head(whole, std::string(1'000'000, '\x5f')));
  EXPECT_HAS(warning(), "unsupported kind");
  write("scene.history", with_head(whole, "\xba\x7f\xff\xff\xff"));
  EXPECT_HAS(warning(), "truncated");
  write("scene.history", with_head(whole, std::string("\x9a\x00\x4c\x4b\x40", 5) + std::string(5'000'000, '\0')));
  EXPECT_HAS(warning(), "too many items");
  write("scene.history", "");
  EXPECT_NE(warning(), "");
  fs::remove(history_file());
  fs::create_directory(history_file());
  EXPECT_HAS(warning(), "not a file");
}

}  // namespace
}  // namespace simplexseg
