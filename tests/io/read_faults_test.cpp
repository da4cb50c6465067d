// SPDX-License-Identifier: Apache-2.0
// Files that change or fail during reading give a one-line error.
#include <sys/resource.h>
#include <unistd.h>

#include "io/mesh/mesh_io.h"
#include "io/platform/files.h"
#include "io/scene/scene_io.h"
#include "io/source/volume_source.h"
#include "io/volume/volume_io.h"
#include "mesh/simplex_mesh.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::error_of;

const char* const kVolumes[] = {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"};

class ReadFaults : public test::FolderTest {
 protected:
  fs::path make(const char* name) {
    write_volume(folder / name, test::odd_volume(VoxelType::Int16));
    return folder / name;
  }
};

TEST(OneLine, ControlCharactersBecomeSpacesAndCutsRespectCharacters) {
  EXPECT_EQ(one_line(" a\n\tb\x7f "), "a b");
  EXPECT_EQ(one_line("abcd", 4), "abcd");
  EXPECT_EQ(one_line("abcde", 4), "abcd ...");
  const std::string two = "\xc3\xa9", three = "\xe2\x82\xac", four = "\xf0\x9f\x99\x82";
  for (const std::string& character : {two, three, four})
    for (std::size_t cut = 1; cut < character.size(); ++cut)
      EXPECT_EQ(one_line("ab" + character + "c", 2 + cut), "ab ...") << cut;
  EXPECT_EQ(one_line(two + two + "c", 4), two + two + " ...");
  EXPECT_EQ(one_line(std::string(9, '\x80'), 6).size(), 7u) << "not UTF-8";
}

TEST_F(ReadFaults, AFileThatIsRemovedBetweenHeaderAndVoxels) {
  for (const char* name : kVolumes) {
    const fs::path path = make(name);
    const VolumeSource source = open_volume(path);
    fs::remove(path);
    EXPECT_HAS(error_of([&] { source.read(); }), name);
  }
}

TEST_F(ReadFaults, AFileThatIsTruncatedBetweenHeaderAndVoxels) {
  for (const char* name : kVolumes) {
    const fs::path path = make(name);
    const VolumeSource source = open_volume(path);
    fs::resize_file(path, fs::file_size(path) - 20);
    const std::string message = error_of([&] { source.read(); });
    EXPECT_HAS(message, name);
    EXPECT_TRUE(message.find("truncated") != std::string::npos || message.find("damaged") != std::string::npos)
        << message;
  }
}

TEST_F(ReadFaults, FilesWithoutReadPermission) {
  for (const char* name : kVolumes) make(name);
  write_mesh(folder / "a.ply", make_sphere({0, 0, 0}, 1, 0));
  write("a.json", R"({"simplexseg_scene": 1})");
  fs::permissions(folder, fs::perms::all);
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha", "a.ply", "a.json"}) {
    const fs::path path = folder / name;
    fs::permissions(path, fs::perms::none);
    const bool root = ::geteuid() == 0;
    ASSERT_TRUE(!root || ::seteuid(65534) == 0);
    std::string message;
    try {
      const std::string ending = path.extension();
      if (ending == ".ply")
        read_mesh(path);
      else if (ending == ".json")
        read_scene(path);
      else
        load_volume(path);
    } catch (const Error& error) {
      message = error.what();
    }
    ASSERT_TRUE(!root || ::seteuid(0) == 0);
    EXPECT_HAS(message, name);
    EXPECT_HAS(message, "ermission");
  }
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/// The check of the available memory passes, but the allocation fails.
TEST_F(ReadFaults, AllocationFailure) {
  std::string bytes = test::nifti_bytes(folder, test::odd_volume(VoxelType::Int16)).substr(0, 352);
  for (int a = 0; a < 3; ++a) test::patch(bytes, 42 + 2 * a, std::int16_t(600));
  const fs::path path = write("large.nii", bytes);
  std::error_code error;
  fs::resize_file(path, 352 + 2ull * 600 * 600 * 600, error);
  if (error) GTEST_SKIP() << "no sparse files on this file system";
  if (available_memory() < (std::size_t(1) << 30)) GTEST_SKIP() << "less than 1 GiB of memory";
  std::ifstream stream("/proc/self/statm");
  std::size_t pages = 0;
  stream >> pages;
  rlimit kept{};
  ::getrlimit(RLIMIT_AS, &kept);
  const rlimit limit{pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + (std::size_t(128) << 20),
                     kept.rlim_max};
  ::setrlimit(RLIMIT_AS, &limit);
  const std::string message = error_of([&] { load_volume(path); });
  ::setrlimit(RLIMIT_AS, &kept);
  EXPECT_HAS(message, "memory");
}
#endif

}  // namespace
}  // namespace simplexseg
