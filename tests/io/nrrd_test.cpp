// SPDX-License-Identifier: Apache-2.0
// NRRD with all spaces, units and encodings.
#include <bzlib.h>

#include <array>

#include "core/number_text.h"
#include "io/labels/labels_io.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

using test::bytes_of;
using test::error_of;
using test::same_voxels;

class Nrrd : public test::FolderTest {
 protected:
  /// Loads a volume of 2 x 3 x 4 int16 voxels, whose values are their offsets, with the given header fields.
  LoadedVolume load_with(const std::string& fields) {
    std::string voxels;
    for (int v = 0; v < 24; ++v) voxels += {static_cast<char>(v), '\0'};
    return load_volume(write("a.nrrd", "NRRD0005\ntype: short\ndimension: 3\nsizes: 2 3 4\nendian: little\n" + fields +
                                           "encoding: raw\n\n" + voxels));
  }
  std::string refusal(const std::string& fields) {
    return error_of([&] { load_with(fields); });
  }
};

const char* const kOblique = "space directions: (2,0.5,0) (-0.25,3,0) (0,0.125,4)\nspace origin: (10,20,30)\n";
const Eigen::Vector3d kColumns[] = {{2, 0.5, 0}, {-0.25, 3, 0}, {0, 0.125, 4}};
const Eigen::Vector3d kOrigin(10, 20, 30);

/// Unit vector in LPS of an axis letter.
Eigen::Vector3d lps_of(char letter) {
  switch (letter) {
    case 'L':
      return {1, 0, 0};
    case 'R':
      return {-1, 0, 0};
    case 'P':
      return {0, 1, 0};
    case 'A':
      return {0, -1, 0};
    case 'S':
      return {0, 0, 1};
    default:
      return {0, 0, -1};
  }
}

std::string long_form(const std::string& code) {
  std::string words;
  for (const char letter : code) {
    for (const char* word : {"left", "right", "anterior", "posterior", "superior", "inferior"}) {
      if (lower_ascii({&letter, 1})[0] == word[0]) words.append(words.empty() ? "" : "-").append(word);
    }
  }
  return words;
}

TEST_F(Nrrd, EverySpaceIsConvertedToLps) {
  int codes = 0;
  const std::string pairs[3] = {"LR", "AP", "SI"};
  std::string order = "012";
  do {
    for (int signs = 0; signs < 8; ++signs) {
      std::string code;
      for (int a = 0; a < 3; ++a) code += pairs[order[a] - '0'][signs >> a & 1];
      ++codes;
      const auto expected = [&](const Eigen::Vector3d& v) {
        return Eigen::Vector3d(v[0] * lps_of(code[0]) + v[1] * lps_of(code[1]) + v[2] * lps_of(code[2]));
      };
      const std::string small = lower_ascii(code);
      for (const std::string& name : {code, small, long_form(code), code + "T", long_form(code) + "-time"}) {
        const bool time = name.size() == 4 || name.ends_with("-time");
        std::string fields = kOblique;
        for (std::size_t at; time && (at = fields.find(')')) != std::string::npos;) fields.replace(at, 1, ",0]");
        for (char& c : fields) c = c == ']' ? ')' : c;
        const LoadedVolume loaded = load_with("space: " + name + "\n" + fields);
        EXPECT_EQ(loaded.warnings.size(), 1u) << name;  // axes not orthogonal
        const Eigen::Affine3d world = loaded.volume.geometry().world_from_index();
        EXPECT_LT((world.translation() - expected(kOrigin)).norm(), 1e-12) << name;
        for (int a = 0; a < 3; ++a)
          EXPECT_LT((world.linear().col(a) - expected(kColumns[a])).norm(), 1e-12) << name << a;
        EXPECT_EQ(loaded.volume.value(1, 2, 3), 23);
      }
    }
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(codes, 48);
}

TEST_F(Nrrd, SpacesWithoutAnatomicalAxesAreAWarning) {
  const std::string unknown = "the patient's left and right are unknown";
  for (const char* space : {"scanner-xyz", "3D-right-handed", "3D-left-handed", "ScannerXYZ"}) {
    const LoadedVolume loaded = load_with(std::string("space: ") + space + "\n" + kOblique);
    ASSERT_EQ(loaded.warnings.size(), 2u) << space;
    EXPECT_HAS(loaded.warnings[0], space);
    EXPECT_HAS(loaded.warnings[0], unknown);
    EXPECT_TRUE(loaded.volume.geometry().origin_mm.isApprox(kOrigin));
  }
  EXPECT_HAS(load_with(std::string("space dimension: 3\n") + kOblique).warnings.at(0), unknown);
  const LoadedVolume none = load_with("spacings: 0.5 1 2\naxis mins: 4 5 6\ncenters: node cell ???\n");
  ASSERT_EQ(none.warnings.size(), 1u);
  EXPECT_HAS(none.warnings[0], unknown);
  EXPECT_TRUE(none.volume.geometry().spacing_mm.isApprox(Eigen::Vector3d(0.5, 1, 2)));
  EXPECT_TRUE(none.volume.geometry().origin_mm.isApprox(Eigen::Vector3d(4, 5.5, 7)));
  EXPECT_HAS(load_with("").warnings.at(0), "1 mm is assumed");
  for (const char* space : {"left-left-superior", "LPL", "LP", "left-posterior", "head-foot-left", "XYZ", ""})
    EXPECT_HAS(refusal(std::string("space: ") + space + "\n" + kOblique), "space") << space;
}

TEST_F(Nrrd, UnitsOfLengthBecomeMillimetres) {
  const std::string space = std::string("space: LPS\n") + kOblique;
  const std::pair<const char*, double> units[] = {{"mm", 1},  {"\"mm\"", 1}, {"\"\"", 1},       {"cm", 10},
                                                  {"m", 1e3}, {"um", 1e-3},  {"microns", 1e-3}, {"Meters", 1e3}};
  for (const auto& [unit, mm] : units) {
    const std::string three = std::string(unit) + " " + unit + " " + unit;
    const LoadedVolume loaded = load_with(space + "space units: " + three + "\n");
    EXPECT_LT((loaded.volume.geometry().origin_mm - mm * kOrigin).norm(), 1e-9 * mm) << unit;
    EXPECT_LT(std::abs(loaded.volume.geometry().spacing_mm[2] / (mm * kColumns[2].norm()) - 1), 1e-12) << unit;
    EXPECT_EQ(loaded.warnings.size(), mm == 1 ? 1u : 2u) << unit;
  }
  // One unit per axis of the space, in the order of the space.
  const LoadedVolume mixed = load_with("space: ASL\nspace units: \"cm\" \"mm\" \"m\"\n" + std::string(kOblique));
  EXPECT_LT((mixed.volume.geometry().origin_mm - Eigen::Vector3d(30000, -100, 20)).norm(), 1e-9);
  EXPECT_HAS(refusal(space + "space units: \"s\" \"s\" \"s\"\n"), "'s' is not a known unit of length");
  EXPECT_HAS(refusal(space + "space units: \"mm\" \"mm\"\n"), "2 values instead of 3");
  EXPECT_TRUE(load_with("spacings: 1 1 2\nunits: cm cm cm\n")
                  .volume.geometry()
                  .spacing_mm.isApprox(Eigen::Vector3d(10, 10, 20)));
  EXPECT_HAS(refusal("spacings: 1 1 2\nunits: pixel pixel pixel\n"), "'pixel'");
}

TEST_F(Nrrd, EveryEncodingGivesTheSameVoxels) {
  const Volume volume = test::odd_volume(VoxelType::Int16);
  const auto values = volume.voxels<std::int16_t>();
  const std::string raw(static_cast<const char*>(volume.data()), volume.bytes());
  std::string swapped = raw, text, hex, half;
  for (std::size_t b = 0; b < raw.size(); b += 2) std::swap(swapped[b], swapped[b + 1]);
  for (const std::int16_t v : values) text += std::to_string(v) + (text.size() % 3 ? "\n" : " , ");
  for (const unsigned char c : raw) {
    char digits[4];
    std::snprintf(digits, sizeof digits, "%02x\n", c);
    hex.append(digits, hex.size() % 5 ? 2 : 3);
  }
  std::string packed(1000, '\0');
  unsigned size = 1000;
  ASSERT_EQ(BZ2_bzBuffToBuffCompress(packed.data(), &size, const_cast<char*>(raw.data()),
                                     static_cast<unsigned>(raw.size()), 9, 0, 0),
            BZ_OK);
  const std::string bzip2 = packed.substr(0, size), gzip = bytes_of(test::write_gzip(folder / "p.gz", raw));
  const std::string fields =
      "NRRD0004\n# a comment\nkey:=value\ntype: int16\ndimension: 3\nsizes: 5 4 3\nspace: LPS\n"
      "space directions: (1,0,0) (0,1,0) (0,0,1)\n";
  struct Case {
    const char *encoding, *more;
    const std::string& bytes;
  };
  const Case cases[] = {{"raw", "endian: little\n", raw},
                        {"raw", "endian: big\n", swapped},
                        {"txt", "", text},
                        {"ASCII", "", text},
                        {"hex", "endian: little\n", hex},
                        {"gzip", "endian: little\n", gzip},
                        {"gz", "endian: little\n", gzip},
                        {"bzip2", "endian: little\n", bzip2},
                        {"bz2", "endian: little\n", bzip2},
                        {"raw", "endian: little\r\nbyte skip: -1\n", raw}};
  for (const Case& c : cases) {
    const std::string header = fields + c.more + "encoding: " + c.encoding + "\n";
    SCOPED_TRACE(header);
    EXPECT_TRUE(same_voxels(read_volume(write("a.nrrd", header + "\n" + c.bytes)), volume));
    write("a.data", c.bytes);
    EXPECT_TRUE(same_voxels(read_volume(write("a.nhdr", header + "data file: a.data\n")), volume));
    EXPECT_EQ(read_volume_info(folder / "a.nhdr").file_count, 2);
    for (std::size_t cut = 1; cut < c.bytes.size(); cut += 7) {
      write("a.nrrd", header + "\n" + c.bytes.substr(0, c.bytes.size() - cut));
      // Text can be cut within its last number, and compressed data within their checksum, without an error.
      if (c.bytes == text && cut < 8) continue;
      error_of([&] { load_volume(folder / "a.nrrd"); });
    }
  }
  std::string wrong = bzip2;
  wrong[wrong.size() / 2] ^= 1;
  write("a.nrrd", fields + "endian: little\nencoding: bzip2\n\n" + wrong);
  EXPECT_HAS(error_of([&] { load_volume(folder / "a.nrrd"); }), "damaged");
  write("a.nrrd", fields + "encoding: zstd\n\n" + raw);
  EXPECT_HAS(error_of([&] { load_volume(folder / "a.nrrd"); }), "zstd");
  write("a.nrrd", fields + "encoding: text\n\n" + text.substr(0, 20) + "70000 " + text);
  EXPECT_HAS(error_of([&] { load_volume(folder / "a.nrrd"); }), "70000");
}

TEST_F(Nrrd, VoxelsInSeveralFiles) {
  const std::string fields = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 3\nencoding: raw\nspacings: 1 1 1\n";
  for (int i = 0; i < 3; ++i)
    write(std::string("s").append(std::to_string(i + 8)).append(".raw"),
          std::string("header\n").append(2, char('a' + i)));
  for (const std::string names :
       {"s%d.raw 8 10 1", "LIST\ns8.raw\ns9.raw\ns10.raw\n", "LIST 2\ns8.raw\ns9.raw\ns10.raw"}) {
    for (const char* skip : {"byte skip: 7\n", "line skip: 1\n", "byteskip: -1\n"}) {
      const Volume v = read_volume(write("s.nhdr", fields + skip + "data file: " + names));
      EXPECT_EQ(v.value(1, 0, 0), 'a');
      EXPECT_EQ(v.value(0, 0, 2), 'c');
    }
  }
  const auto rejection = [&](const std::string& names) {
    write("s.nhdr", fields + "byte skip: 7\ndata file: " + names + "\n");
    return error_of([&] { load_volume(folder / "s.nhdr"); });
  };
  EXPECT_HAS(rejection("s%d.raw 8 11 1"), "does not name one file for each");
  EXPECT_HAS(rejection("s%d.raw 1 2000000000 1"), "does not name one file for each");
  EXPECT_HAS(rejection("s%n%s.raw 8 10 1"), "%03d");
  EXPECT_HAS(rejection("LIST\ns8.raw"), "1 file for 3 slices");
  EXPECT_HAS(rejection("s%d.raw 9 11 1"), "s11.raw' is missing");
}

TEST_F(Nrrd, NonSpatialAxes) {
  const std::string rest = "space: LPS\nencoding: raw\n";
  const auto info = [&](const std::string& fields) {
    return read_volume_info(write("k.nrrd", "NRRD0004\ntype: uchar\n" + fields + rest + "\n" + std::string(24, 'x')));
  };
  VolumeInfo read = info(
      "dimension: 4\nsizes: 3 2 2 2\nspace directions: none (1,0,0) (0,2,0) (0,0,3)\n"
      "kinds: RGB-color domain domain domain\n");
  EXPECT_EQ(read.components, 3);
  EXPECT_EQ(read.frames, 1);
  EXPECT_EQ(read.geometry.size, (std::array<int, 3>{2, 2, 2}));
  EXPECT_TRUE(read.geometry.spacing_mm.isApprox(Eigen::Vector3d(1, 2, 3)));
  read = info(
      "dimension: 4\nsizes: 2 2 2 3\nspace directions: (1,0,0) (0,2,0) (0,0,3) none\n"
      "kinds: domain domain domain time\n");
  EXPECT_EQ(read.components, 1);
  EXPECT_EQ(read.frames, 3);
  read = info("dimension: 2\nsizes: 4 6\nspace directions: (0,2,0) (0,0,3)\n");
  EXPECT_EQ(read.geometry.size, (std::array<int, 3>{4, 6, 1}));
  EXPECT_TRUE(read.geometry.direction.col(2).isApprox(Eigen::Vector3d(1, 0, 0)));
}

TEST_F(Nrrd, InvalidHeaders) {
  const auto rejection = [&](const std::string& header) {
    write("h.nrrd", header + "\n\nabcdefgh");
    return error_of([&] { load_volume(folder / "h.nrrd"); });
  };
  const std::string start = "NRRD0004\ntype: uchar\nencoding: raw\n";
  EXPECT_HAS(rejection("NRRX0004\n"), "not a readable NRRD");
  EXPECT_HAS(rejection(start + "sizes: 2 2 2"), "dimension");
  EXPECT_HAS(rejection(start + "dimension: 99999999999999999999\nsizes: 2 2 2"), "dimension");
  EXPECT_HAS(rejection(start + "dimension: 3\nsizes: 2 2"), "sizes");
  EXPECT_HAS(rejection(start + "dimension: 3\nsizes: 2 2 -2"), "-2");
  EXPECT_HAS(rejection(start + "dimension: 3\nsizes: 2 2 2\nsizes: 2 2 2"), "twice");
  EXPECT_HAS(rejection(start + "dimension: 3\nsizes: 2 2 2\nspacings: 1 x 1"), "'x'");
  EXPECT_HAS(rejection(start + "dimension: 3\nsizes: 2 2 2\nbyte skip: -2"), "byte skip");
  EXPECT_HAS(rejection(start + "dimension: 3\nsizes: 2 2 2\nspace: LPS\nspace directions: (1,0) (0,1,0) (0,0,1)"),
             "space directions");
  EXPECT_HAS(rejection(start + "dimension: 3\nsizes: 2 2 2\nspace: LPS\nspace directions: (0,5,0) (0,1,0 0) (0,0,1)"),
             "with a decimal point");
  EXPECT_HAS(rejection("NRRD0004\ntype: block\nencoding: raw\ndimension: 3\nsizes: 2 2 2"), "block");
}

/// Header written by 3D Slicer 5.
const char* const kSlicer =
    "NRRD0004\n# Complete NRRD file format specification at:\n# http://teem.sourceforge.net/nrrd/format.html\n"
    "type: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
    "space directions: (1,0,0) (0,1,0) (0,0,1)\nkinds: domain domain domain\nencoding: raw\nspace origin: (0,0,0)\n"
    "Segment0_Color:=0.501961 0 1\nSegment0_ColorAutoGenerated:=1\nSegment0_Extent:=0 0 0 0 0 0\n"
    "Segment0_ID:=Segment_1\nSegment0_LabelValue:=7\nSegment0_Layer:=0\nSegment0_Name:=right kidney\n"
    "Segment0_Tags:=Segmentation.Status:inprogress|TerminologyEntry:Segmentation category and type - 3D Slicer General "
    "Anatomy list~SCT^123037004^Anatomical Structure~SCT^64033007^Kidney~SCT^24028007^Right~Anatomic codes - DICOM "
    "master "
    "list~^^~^^|\nSegment1_ID:=spleen\n"
    "Segment1_Tags:=TerminologyEntry:Segmentation category~SCT^85756007^Tissue|\n"
    "Segment1_LabelValue:=2\nSegmentation_MasterRepresentation:=Binary labelmap\n\n";

TEST_F(Nrrd, SegmentsOf3dSlicerHaveNamesAndColours) {
  const LoadedVolume loaded = load_volume(write("a.seg.nrrd", kSlicer + std::string("\7\0\0\2\0\0\0\0", 8)));
  EXPECT_EQ(loaded.volume.value(0, 0, 0), 7);
  ASSERT_EQ(loaded.segments.size(), 2u);
  EXPECT_EQ(loaded.segments[0], (SegmentName{7,
                                             "right kidney",
                                             {128, 0, 255},
                                             {{"SCT", "123037004", "Anatomical Structure"},
                                              {"SCT", "64033007", "Kidney"},
                                              {"SCT", "24028007", "Right"}}}));
  EXPECT_TRUE(loaded.segments[1].code.empty()) << "its entry has no type";
  EXPECT_EQ(loaded.segments[1].value, 2);
  EXPECT_EQ(loaded.segments[1].name, "spleen");
}

TEST_F(Nrrd, SegmentsAreWrittenLikeThoseOf3dSlicer) {
  VolumeGeometry geometry;
  geometry.size = {4, 3, 2};
  Volume labels(geometry, VoxelType::UInt16);
  labels.voxels<std::uint16_t>()[labels.offset(1, 2, 0)] = 300;
  labels.voxels<std::uint16_t>()[labels.offset(3, 1, 1)] = 300;
  labels.voxels<std::uint16_t>()[labels.offset(0, 0, 1)] = 4;
  write_labels(folder / "a.seg.nrrd", labels, {{300, "two\nlines", {255, 0, 51}}, {9, "nowhere"}});
  const std::string header = test::bytes_of(folder / "a.seg.nrrd");
  for (const char* line :
       {"\nSegment0_Color:=1 0 0.2\n", "\nSegment0_Extent:=1 3 1 2 0 1\n", "\nSegment0_LabelValue:=300\n",
        "\nSegment0_Name:=two lines\n", "\nSegment1_Extent:=0 -1 0 -1 0 -1\n", "\nSegment2_LabelValue:=4\n",
        "\nSegment2_Name:=label 4\n", "\nSegment2_Extent:=0 0 0 0 1 1\n",
        "\nSegmentation_MasterRepresentation:=Binary labelmap\n"})
    EXPECT_HAS(header, line);
  const LoadedVolume loaded = load_volume(folder / "a.seg.nrrd");
  EXPECT_TRUE(test::same_voxels(labels, loaded.volume));
  EXPECT_EQ(loaded.segments.size(), 3u);
  write_labels(folder / "a.nrrd", labels, {{300, "kidney"}});
  EXPECT_EQ(test::bytes_of(folder / "a.nrrd").find("Segment"), std::string::npos);
}

TEST_F(Nrrd, OverlappingSegmentsAreReadFromTheirLayers) {
  std::string bytes = kSlicer;
  const auto replace = [&](const std::string& from, const std::string& to) {
    bytes.replace(bytes.find(from), from.size(), to);
  };
  replace("dimension: 3", "dimension: 4");
  replace("sizes: 2", "sizes: 2 2");
  replace("directions: ", "directions: none ");
  replace("kinds: ", "kinds: list ");
  replace("Segment1_LabelValue:=2", "Segment1_LabelValue:=2\nSegment1_Layer:=1");
  // Each pair of bytes is the value of a voxel in both layers.
  const std::string pairs(
      "\7\2"
      "\7\0"
      "\0\2"
      "\0\0"
      "\7\2"
      "\0\0"
      "\0\0"
      "\3\0",
      16);
  const LoadedVolume all = load_volume(write("a.seg.nrrd", bytes + pairs));
  ASSERT_EQ(all.warnings.size(), 2u);
  EXPECT_HAS(all.warnings[0], "2 voxels belong to several segments");
  EXPECT_HAS(all.warnings[1], "1 voxel has a value that no segment has");
  const std::array<int, 8> highest{7, 7, 2, 0, 7, 0, 0, 0};
  for (int v = 0; v < 8; ++v) EXPECT_EQ(all.volume.value(v % 2, v / 2 % 2, v / 4), highest[std::size_t(v)]) << v;
  LabelFile file(folder / "a.seg.nrrd");
  EXPECT_TRUE(file.reads_alone());
  const LoadedLabels spleen = file.read({.name = "Spleen"});
  EXPECT_TRUE(spleen.warnings.empty());
  const std::array<int, 8> alone{2, 0, 2, 0, 2, 0, 0, 0};
  for (int v = 0; v < 8; ++v) EXPECT_EQ(spleen.volume.value(v % 2, v / 2 % 2, v / 4), alone[std::size_t(v)]) << v;
  const std::vector<LabelCount> counts = file.count();
  ASSERT_EQ(counts.size(), 2u);
  EXPECT_EQ(counts[0].voxels, 3u) << "spleen";
  EXPECT_EQ(counts[1].voxels, 3u) << "kidney";
  EXPECT_HAS(test::error_of([&] { file.read({.label = 3}); }), "its labels are 7 (right kidney), 2 (spleen)");
  // 3D Slicer numbers the segments of each layer from 1.
  replace("LabelValue:=7", "LabelValue:=2");
  const LoadedVolume numbered = load_volume(write("b.seg.nrrd", bytes + pairs));
  ASSERT_EQ(numbered.segments.size(), 2u);
  EXPECT_EQ(numbered.segments[0].value, 1);
  EXPECT_EQ(numbered.segments[1].value, 2);
  EXPECT_HAS(numbered.warnings[0], "the segments have the numbers 1 to 2");
  replace("Layer:=1", "Layer:=2");
  EXPECT_HAS(test::error_of([&] { load_volume(write("c.seg.nrrd", bytes + pairs)); }), "in layer 2");
}

}  // namespace
}  // namespace simplexseg
