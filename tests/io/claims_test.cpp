// SPDX-License-Identifier: Apache-2.0
// Headers that announce more data than their file can contain are rejected before memory is allocated.
#include <bzlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include "dicom_files.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::error_of;

#if !defined(__SANITIZE_ADDRESS__)
/// Size of the address space, bytes.
std::size_t address_space() {
  std::ifstream stream("/proc/self/statm");
  std::size_t pages = 0;
  stream >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}
#endif

class Claims : public test::FolderTest {
 protected:
  /// Expects that reading the volume and reading its header fail without allocating the claimed memory.
  void expect_rejected(const fs::path& path, const std::string& why) {
    SCOPED_TRACE(path);
#if !defined(__SANITIZE_ADDRESS__)
    // The limit of 256 MB above the current use is below all claimed sizes.
    rlimit kept{};
    ::getrlimit(RLIMIT_AS, &kept);
    const rlimit limit{address_space() + (std::size_t(256) << 20), kept.rlim_max};
    ::setrlimit(RLIMIT_AS, &limit);
#endif
    const std::string message = error_of([&] { load_volume(path); });
#if !defined(__SANITIZE_ADDRESS__)
    ::setrlimit(RLIMIT_AS, &kept);
#endif
    EXPECT_HAS(message, why);
    EXPECT_HAS(message, path.filename().string());
    EXPECT_EQ(error_of([&] { read_volume_info(path); }), message);
  }
  void expect_rejected(const std::string& name, const std::string& bytes, const std::string& why) {
    expect_rejected(write(name, bytes), why);
  }
};

const char* const kMeta =
    "ObjectType = Image\nNDims = 3\nDimSize = 2000 2000 2000\nElementType = MET_UCHAR\nElementSpacing = 1 1 1\n";
const char* const kNrrd =
    "NRRD0004\ntype: uchar\ndimension: 3\nspace: LPS\nsizes: 2000 2000 2000\n"
    "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n";

TEST_F(Claims, MetaImage) {
  expect_rejected("a.mha", kMeta + std::string("ElementDataFile = LOCAL\nabc"), "truncated");
  expect_rejected("z.mha",
                  kMeta + std::string("CompressedData = True\nCompressedDataSize = 3\nElementDataFile = LOCAL\nabc"),
                  "truncated");
  expect_rejected("t.mha", kMeta + std::string("BinaryData = False\nElementDataFile = LOCAL\n1 2 3"), "truncated");
  write("a.raw", "abc");
  write("a.zraw", "abc");
  write("a.mhd", kMeta + std::string("ElementDataFile = a.raw\n"));
  write("z.mhd", kMeta + std::string("CompressedData = True\nElementDataFile = a.zraw\n"));
  write("e.mhd", kMeta + std::string("HeaderSize = -1\nElementDataFile = a.raw\n"));
  for (const auto& [name, data] : {std::pair("a.mhd", "a.raw"), {"z.mhd", "a.zraw"}, {"e.mhd", "a.raw"}}) {
    const std::string message = error_of([&] { load_volume(folder / name); });
    EXPECT_HAS(message, data);
    EXPECT_HAS(message, "truncated");
  }
}

TEST_F(Claims, MetaImagesThatCausedEndlessLoops) {
  expect_rejected("one.mha", "NDims = 2000000000\nDimSize = 1\n", "no key ElementDataFile");
  expect_rejected("two.mha",
                  "ObjectType = Image\nNDims = 999999999999\nDimSize = 2 2 2\nElementType = MET_UCHAR\n"
                  "ElementDataFile = LOCAL\n12345678",
                  "NDims");
  expect_rejected("many.mha",
                  "ObjectType = Image\nNDims = 3\nDimSize = 1 1 2000000000\nElementType = MET_UCHAR\n"
                  "ElementDataFile = s%d.raw 1 2000000000 1\n",
                  "does not name one file for each");
}

TEST_F(Claims, Nrrd) {
  for (const char* encoding : {"raw", "gzip", "bzip2", "ascii", "hex"}) {
    const std::string fields = kNrrd + std::string("encoding: ") + encoding + "\n";
    expect_rejected("a.nrrd", fields + "\n1 2 3", "truncated");
    write("a.data", "1 2 3");
    write("a.nhdr", fields + "data file: a.data\n");
    EXPECT_HAS(error_of([&] { load_volume(folder / "a.nhdr"); }), "a.data': truncated") << encoding;
  }
}

TEST_F(Claims, NiftiAndAnalyze) {
  std::string bytes = test::nifti_bytes(folder, test::odd_volume(VoxelType::UInt8)).substr(0, 352);
  for (int a = 0; a < 3; ++a) test::patch(bytes, 42 + 2 * a, std::int16_t(2000));
  expect_rejected("a.nii", bytes, "truncated");
  expect_rejected(test::write_gzip(folder / "a.nii.gz", bytes), "truncated");
  std::string header = bytes.substr(0, 348);
  header.replace(344, 4, std::string("ni1\0", 4));
  test::patch(header, 108, 0.0f);
  for (const std::string& name : {std::string("pair"), std::string("old")}) {
    if (name == "old") header.replace(252, 96, 96, '\0');
    write(name + ".hdr", header);
    write(name + ".img", "abc");
    EXPECT_HAS(error_of([&] { load_volume(folder / (name + ".hdr")); }), ".img': truncated");
    fs::remove(folder / (name + ".img"));
    test::write_gzip(folder / (name + ".img.gz"), "abc");
    EXPECT_HAS(error_of([&] { load_volume(folder / (name + ".hdr")); }), ".img.gz': truncated");
  }
}

std::string gipl_of(const std::array<int, 4>& size, int type, const std::string& voxels) {
  std::string bytes(256, '\0');
  const auto put = [&bytes]<class T>(std::size_t at, T value) {
    std::memcpy(&bytes[at], &value, sizeof value);
    std::reverse(&bytes[at], &bytes[at] + sizeof value);
  };
  for (std::size_t a = 0; a < 4; ++a) {
    put(2 * a, static_cast<std::uint16_t>(size[a]));
    put(10 + 4 * a, 0.5f * static_cast<float>(a + 1));
    put(204 + 8 * a, 10.0 * static_cast<double>(a));
  }
  put(8, static_cast<std::uint16_t>(type));
  put(252, std::uint32_t(719555000));
  return bytes + voxels;
}

TEST_F(Claims, Gipl) {
  const std::string huge = gipl_of({2000, 2000, 2000, 1}, 8, "abc");
  expect_rejected("a.gipl", huge, "truncated");
  expect_rejected(test::write_gzip(folder / "a.gipl.gz", huge), "truncated");
}

TEST_F(Claims, GiplIsReadWithAndWithoutCompression) {
  const std::string bytes = gipl_of({3, 2, 1, 1}, 15, std::string("\0\1\0\2\0\3\0\4\0\5\xff\xff", 12));
  write("a.gipl", bytes);
  test::write_gzip(folder / "a.gipl.gz", bytes);
  test::write_gzip(folder / "a.dat", bytes);  // extension lost
  for (const char* name : {"a.gipl", "a.gipl.gz", "a.dat"}) {
    const LoadedVolume read = load_volume(folder / name);
    EXPECT_EQ(read.format, "GIPL");
    EXPECT_EQ(read.volume.type(), VoxelType::Int16);
    EXPECT_EQ(read.volume.geometry().size, (std::array<int, 3>{3, 2, 1}));
    EXPECT_EQ(read.volume.value(1, 0, 0), 2);
    EXPECT_EQ(read.volume.value(2, 1, 0), -1);
    EXPECT_TRUE(read.volume.geometry().spacing_mm.isApprox(Eigen::Vector3d(0.5, 1, 1.5)));
    EXPECT_TRUE(read.volume.geometry().origin_mm.isApprox(Eigen::Vector3d(0, 10, 20)));
    ASSERT_EQ(read.warnings.size(), 1u);
    EXPECT_HAS(read.warnings[0], "orientation");
  }
  EXPECT_HAS(error_of([&] { load_volume(write("four.gipl", gipl_of({2, 1, 1, 4}, 8, "abcdef"))); }), "truncated");
  EXPECT_HAS(error_of([&] { load_volume(write("odd.gipl", gipl_of({2, 1, 1, 1}, 160, "abcdef"))); }), "160");
}

/// The message names the format of the compressed file.
TEST_F(Claims, CompressedFilesAreRejectedByFormat) {
  const auto rejection = [&](const std::string& bytes) {
    test::write_gzip(folder / "a.gz", bytes);
    return error_of([&] { load_volume(folder / "a.gz"); });
  };
  const auto unpack = [](const std::string& format) {
    return "it is a " + format + " file compressed with gzip; decompress it";
  };
  EXPECT_HAS(rejection(kNrrd), unpack("NRRD"));
  EXPECT_HAS(rejection(kMeta), unpack("MetaImage"));
  EXPECT_HAS(rejection("\x89HDF\r\n\x1a\n"), unpack("MINC"));
  EXPECT_HAS(rejection("This is a text."), "is not NIfTI");
  EXPECT_EQ(rejection("This is a text.").find("decompress it first"), std::string::npos);
}

TEST_F(Claims, Minc) {
  const fs::path good = test::data_folder() / "bad_input" / "nibabel__minc2_1_scale.mnc";
  REQUIRE_DATA(good);
  std::string bytes = bytes_of(good);  // 20 x 20 x 10 voxels
  for (const std::size_t at : {10616u, 10640u})
    for (std::size_t axis = 0; axis < 3; ++axis) test::patch(bytes, at + 8 * axis, std::uint64_t(1000));
  for (const std::size_t at : {5624u, 6640u, 7304u}) test::patch(bytes, at, std::int32_t(1000));
  expect_rejected("a.mnc", bytes, "truncated");
}

/// A stream that expands to much less than its size allows needs only its real size, and is rejected as truncated.
TEST_F(Claims, StreamsThatExpandToLessThanTheBound) {
  std::string zeros(1 << 20, '\0'), packed(1 << 16, '\0');
  unsigned size = 1 << 16;
  ASSERT_EQ(BZ2_bzBuffToBuffCompress(packed.data(), &size, zeros.data(), static_cast<unsigned>(zeros.size()), 9, 0, 0),
            BZ_OK);
  std::string fields = kNrrd;
  fields.replace(fields.find("2000 2000 2000"), 14, "1000 1000 20");
  write("a.nrrd", fields + "encoding: bzip2\n\n" + packed.substr(0, size));
  EXPECT_HAS(error_of([&] { load_volume(folder / "a.nrrd"); }), "truncated");
}

const char* const kJpeg = "1.2.840.10008.1.2.4.70";
const char* const kJ2k = "1.2.840.10008.1.2.4.90";

/// Returns a 16-bit image with these fragments of compressed pixels.
std::string compressed(const char* syntax, int columns, int rows, int frames,
                       const std::vector<std::string>& fragments) {
  test::DicomData data;
  data.text(0x0008, 0x0060, "CS", "OT");
  test::describe_pixels(data, columns, rows, frames);
  data.fragments(fragments);
  return test::dicom_file(data.bytes, "1.2", syntax);
}

TEST_F(Claims, Dicom) {
  const auto claiming = [](std::uint32_t length, bool nested) {
    test::DicomData data, inner;
    const std::string text = std::string("\x08\0\x08\0UN\0\0", 8) + test::bytes_of_numbers(length) + "abcd";
    if (nested)
      data.sequence(0x0008, 0x0006, {text});
    else
      data.bytes = text;
    return test::dicom_file(data.bytes, "1.2");
  };
  for (const bool nested : {false, true})
    expect_rejected("long.dcm", claiming(0xfffffff0, nested), "element (0008,0008) claims 4.3 GB, but");
  expect_rejected("rle.dcm", compressed(test::kRle, 60000, 60000, 1, {std::string(5000, '\1')}), "too small to hold");
  expect_rejected("frames.dcm", compressed(test::kRle, 64, 64, 100000000, {std::string(500, '\1')}),
                  "only 1 of its 100000000 frames");
  std::string j2k("\xff\x4f\xff\x51\0\x29\0\0", 8);
  j2k += std::string("\0\0\0\x40\0\0\0\x40", 8) + std::string(40, '\0');  // 64 x 64 pixels
  expect_rejected("j2k.dcm", compressed(kJ2k, 60000, 60000, 1, {j2k}), "compressed image has 64 x 64 pixels");
  std::string jpeg("\xff\xd8\xff\xc3\0\x0b\x10\xea\x60\xea\x60\1\1\x11\0", 15);  // 60000 x 60000
  jpeg += std::string(40, '\0');
  expect_rejected("jpeg.dcm", compressed(kJpeg, 64, 64, 1, {jpeg}), "compressed image has 60000 x 60000 pixels");
  expect_rejected("jpegs.dcm", compressed(kJpeg, 60000, 60000, 1, {jpeg}), "too small to hold");
}

TEST_F(Claims, ImpossibleSpacings) {
  for (const char* spacing : {"1e308", "1e7", "1e-300", "0", "inf", "nan"}) {
    write("a.mha", std::string("ObjectType = Image\nNDims = 3\nDimSize = 1 1 2\nElementType = MET_UCHAR\n"
                               "ElementSpacing = 1 1 ") +
                       spacing + "\nElementDataFile = LOCAL\nab");
    EXPECT_HAS(error_of([&] { load_volume(folder / "a.mha"); }), "spacing") << spacing;
  }
  write("a.nrrd",
        "NRRD0004\ntype: uchar\ndimension: 3\nspace: LPS\nsizes: 1 1 2\nencoding: raw\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1e308)\n\nab");
  EXPECT_HAS(error_of([&] { load_volume(folder / "a.nrrd"); }), "spacing");
  write("a.nrrd",
        "NRRD0004\ntype: uchar\ndimension: 3\nspace: LPS\nsizes: 1 1 2\nencoding: raw\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,1e300,0)\n\nab");
  EXPECT_HAS(error_of([&] { load_volume(folder / "a.nrrd"); }), "origin");
  std::string bytes = test::nifti_bytes(folder, test::odd_volume(VoxelType::UInt8));
  test::patch(bytes, 280 + 4, 3e38f);
  test::patch(bytes, 252, std::int16_t(0));
  write("a.nii", bytes);
  EXPECT_HAS(error_of([&] { load_volume(folder / "a.nii"); }), "spacing");
}

}  // namespace
}  // namespace simplexseg
