// SPDX-License-Identifier: Apache-2.0
// Failed writes: the old file is unchanged, no temporary file remains, and the error is one line.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <map>

#include "io/mesh/mesh_io.h"
#include "io/picture/picture_io.h"
#include "io/picture/plot_io.h"
#include "io/platform/atomic_file.h"
#include "io/scene/log_io.h"
#include "scene_files.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::error_of;

/// Scope with a limit on file sizes, which acts like a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : before_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &kept_);
    const rlimit limit{bytes, kept_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &kept_);
    std::signal(SIGXFSZ, before_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*before_)(int);
  rlimit kept_{};
};

/// Scope in which tests that run as root use an unprivileged user.
class DroppedPrivileges {
 public:
  DroppedPrivileges() {
    if (::geteuid() == 0) dropped_ = ::seteuid(65534) == 0;
  }
  ~DroppedPrivileges() {
    if (dropped_ && ::seteuid(0) != 0) std::abort();
  }
  DroppedPrivileges(const DroppedPrivileges&) = delete;
  DroppedPrivileges& operator=(const DroppedPrivileges&) = delete;

 private:
  bool dropped_ = false;
};

struct Writer {
  const char* name;
  std::function<void(const fs::path&)> write;
};

Plot curve() {
  Plot plot{"title", "x", "y", false, false, {}};
  PlotSeries series{"series", plot_colour(0), true, false, {}, {}};
  for (int i = 1; i <= 50; ++i) series.x.push_back(i), series.y.push_back(i % 7);
  plot.series = {series};
  return plot;
}

/// Returns a writer for each supported format.
std::vector<Writer> writers() {
  const auto volume = [](const fs::path& path) { write_volume(path, test::odd_volume(VoxelType::Float64)); };
  const auto mesh = [](const fs::path& path) { write_mesh(path, make_sphere({1, 2, 3}, 4, 2)); };
  const auto picture = [](const fs::path& path) {
    Picture made{40, 30, {}};
    for (std::uint32_t i = 0; i < 3600; ++i) made.rgb.push_back(static_cast<std::uint8_t>(i * i * 2654435761u >> 13));
    write_picture(path, made);
  };
  const auto plot = [](const fs::path& path) { write_plot(path, curve(), 300, 200); };
  const auto log = [](const fs::path& path) {
    write_log(path, std::vector<LogEntry>(40, {3, MovePoint{6, {1, 2, 3}, true}}), 5, "scene.json");
  };
  const auto scene = [](const fs::path& path) {
    Scene made = any_scene();
    made.volume_path.clear();
    write_scene(path, made);
  };
  const auto text = [](const fs::path& path) {
    AtomicFile file(path);
    write_bytes(file, std::string(5000, 'x'));
    file.commit();
  };
  return {{"a.nii", volume}, {"a.nii.gz", volume}, {"a.nrrd", volume}, {"a.mha", volume},
          {"a.ply", mesh},   {"a.obj", mesh},      {"a.stl", mesh},    {"a.vtk", mesh},
          {"a.vtp", mesh},   {"a.png", picture},   {"a.ppm", picture}, {"b.png", plot},
          {"b.svg", plot},   {"a.log.json", log},  {"a.json", scene},  {"a.csv", text}};
}

class WriteFaults : public test::FolderTest {
 protected:
  std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.is_regular_file()) files[entry.path().filename()] = bytes_of(entry.path());
    }
    return files;
  }
  fs::path make_leftover(const std::string& name) { return write(name, "half a file"); }
};

TEST_F(WriteFaults, AFullDiskIsReportedAndKeepsTheOldFile) {
  for (const Writer& writer : writers()) {
    SCOPED_TRACE(writer.name);
    const fs::path path = folder / writer.name;
    writer.write(path);
    const auto before = contents();
    // Failure at the start, in the middle and at the last byte.
    const rlim_t size = fs::file_size(path);
    for (const rlim_t limit : {rlim_t(0), size / 2, size - 1}) {
      std::string message;
      {
        const FileSizeLimit limited(limit);
        message = error_of([&] { writer.write(path); });
      }
      EXPECT_HAS(message, "cannot write");
      EXPECT_HAS(message, "File too large");
      EXPECT_TRUE(contents() == before) << limit;
    }
    writer.write(path);  // writing works again
    EXPECT_EQ(contents().size(), before.size());
  }
}

TEST_F(WriteFaults, FoldersWithoutWritePermission) {
  for (const Writer& writer : writers()) writer.write(folder / writer.name);
  const auto before = contents();
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec | fs::perms::group_read |
                              fs::perms::group_exec | fs::perms::others_read | fs::perms::others_exec);
  for (const Writer& writer : writers()) {
    SCOPED_TRACE(writer.name);
    std::string message;
    {
      const DroppedPrivileges dropped;
      message = error_of([&] { writer.write(folder / writer.name); });
    }
    EXPECT_HAS(message, "Permission denied");
    EXPECT_HAS(message, writer.name);
  }
  fs::permissions(folder, fs::perms::owner_all);
  EXPECT_TRUE(contents() == before);
}

TEST_F(WriteFaults, AFolderDeletedDuringAWrite) {
  fs::create_directory(folder / "deeper");
  AtomicFile file(folder / "deeper" / "a.csv");
  write_bytes(file, "bytes");
  fs::remove_all(folder / "deeper");
  EXPECT_HAS(error_of([&] { file.commit(); }), "does not exist");
}

TEST_F(WriteFaults, ATargetThatBecomesAFolder) {
  AtomicFile file(folder / "a.csv");
  write_bytes(file, "bytes");
  fs::create_directory(folder / "a.csv");
  EXPECT_HAS(error_of([&] { file.commit(); }), "a.csv");
}

TEST_F(WriteFaults, ADeviceIsNotReplaced) {
  EXPECT_HAS(error_of([] { AtomicFile file("/dev/null"); }), "device");
  fs::create_symlink("/dev/null", folder / "a.ply");
  EXPECT_HAS(error_of([&] { write_mesh(folder / "a.ply", make_sphere({0, 0, 0}, 1, 1)); }), "device");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(WriteFaults, FilePermissionsAreKept) {
  const fs::path path = write("a.csv", "old");
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
  AtomicFile file(path);
  write_bytes(file, "new");
  file.commit();
  EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(bytes_of(path), "new");
}

TEST_F(WriteFaults, LeftoversOfKilledRunsAreRemovedAtTheNextSave) {
  // A process that is killed in the middle of a write.
  const pid_t writer_process = ::fork();
  ASSERT_GE(writer_process, 0);
  if (writer_process == 0) {
    AtomicFile file(folder / "a.csv");
    file.write("half", 4);
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ::waitpid(writer_process, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_EQ(contents().size(), 1u);
  make_leftover(".simplexseg-12345-0.nii.gz");
  make_leftover(".simplexseg-1-77");  // the process number is in use, but the file is not locked
  const std::vector<std::string> others = {".simplexseg-notes", ".simplexseg-1-", ".simplexseg--1", ".simplexseg-1-2x",
                                           "simplexseg-1-2"};
  for (const std::string& name : others) make_leftover(name);
  fs::create_directory(folder / ".simplexseg-5-5");
  for (const Writer& writer : writers()) {
    SCOPED_TRACE(writer.name);
    make_leftover(".simplexseg-12345-1.mha");
    writer.write(folder / writer.name);
    EXPECT_FALSE(contents().contains(".simplexseg-12345-1.mha"));
  }
  const auto files = contents();
  EXPECT_FALSE(files.contains(".simplexseg-12345-0.nii.gz"));
  EXPECT_FALSE(files.contains(".simplexseg-1-77"));
  for (const std::string& name : others) EXPECT_TRUE(files.contains(name)) << name;
  EXPECT_TRUE(fs::is_directory(folder / ".simplexseg-5-5"));
  for (const auto& [name, bytes] : files)
    EXPECT_FALSE(name.starts_with(".simplexseg-" + std::to_string(writer_process))) << name;
}

TEST_F(WriteFaults, FilesBeingWrittenAreKept) {
  int ready[2], go[2];
  ASSERT_EQ(::pipe(ready), 0);
  ASSERT_EQ(::pipe(go), 0);
  const pid_t writer_process = ::fork();
  ASSERT_GE(writer_process, 0);
  if (writer_process == 0) {  // another process in the middle of a write
    int status = 1;
    try {
      AtomicFile file(folder / "theirs.csv");
      write_bytes(file, "theirs");
      char byte = 'r';
      if (::write(ready[1], &byte, 1) == 1 && ::read(go[0], &byte, 1) == 1) {
        file.commit();
        status = 0;
      }
    } catch (const std::exception&) {
    }
    ::_exit(status);
  }
  char byte;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  AtomicFile mine(folder / "mine.csv");
  write_bytes(mine, "mine");
  AtomicFile other(folder / "other.csv");
  write_bytes(other, "other");
  mine.commit();
  other.commit();
  ASSERT_EQ(::write(go[1], "g", 1), 1);
  int status = 0;
  ::waitpid(writer_process, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(contents(), (std::map<std::string, std::string>{
                            {"mine.csv", "mine"}, {"other.csv", "other"}, {"theirs.csv", "theirs"}}));
  for (const int end : {ready[0], ready[1], go[0], go[1]}) ::close(end);
}

}  // namespace
}  // namespace simplexseg
