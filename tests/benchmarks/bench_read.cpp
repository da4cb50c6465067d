// SPDX-License-Identifier: Apache-2.0
// Time and peak memory of reading a volume of 512 x 512 x 700 16-bit voxels with our readers and ITK's, alternately,
// each in a separate process. bench_read FOLDER [REPETITIONS]: creates missing files of up to 0.4 GB in the folder.
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkImageFileReader.h>
#include <itkImageSeriesReader.h>
#include <itkMetaImageIOFactory.h>
#include <itkNiftiImageIOFactory.h>
#include <itkNrrdImageIOFactory.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <vector>

#include "dicom_files.h"
#include "image/volume.h"
#include "io/volume/volume_io.h"

namespace {

namespace fs = std::filesystem;
using simplexseg::Volume;

/// Volume with smooth shapes and noise of a few values, which is about as compressible as a CT.
Volume made() {
  simplexseg::VolumeGeometry g;
  g.size = {512, 512, 700};
  g.spacing_mm = {0.7, 0.7, 0.8};
  Volume volume(g, simplexseg::VoxelType::Int16);
  std::int16_t* v = volume.voxels<std::int16_t>().data();
  std::uint32_t noise = 1;
  for (int k = 0; k < 700; ++k)
    for (int j = 0; j < 512; ++j)
      for (int i = 0; i < 512; ++i) {
        noise = noise * 1664525u + 1013904223u;
        const bool body = (i - 256) * (i - 256) + (j - 256) * (j - 256) < 200 * 200;
        *v++ = static_cast<std::int16_t>(body ? 40 + ((i / 32 + j / 32 + k / 32) % 4) * 30 + int(noise >> 28) : -1000);
      }
  return volume;
}

/// Writes a series of CT slices, one file each, with this number of unsigned bits.
void write_series(const fs::path& folder, const Volume& volume, int bits) {
  constexpr const char* kCt = "1.2.840.10008.5.1.4.1.1.2";
  const simplexseg::VolumeGeometry& g = volume.geometry();
  const auto slice = static_cast<std::size_t>(g.size[0]) * static_cast<std::size_t>(g.size[1]);
  fs::create_directory(folder);
  for (int k = 0; k < g.size[2]; ++k) {
    simplexseg::test::DicomData data;
    data.text(0x0008, 0x0016, "UI", kCt).text(0x0008, 0x0018, "UI", "1.2.3.4." + std::to_string(k + 1));
    data.text(0x0008, 0x0060, "CS", "CT").text(0x0020, 0x000e, "UI", "1.2.3.8");
    data.text(0x0020, 0x0013, "IS", std::to_string(k + 1));
    data.numbers(0x0020, 0x0032, {0, 0, k * g.spacing_mm[2]}).numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
    simplexseg::test::describe_pixels(data, g.size[0], g.size[1], 0, bits);
    data.numbers(0x0028, 0x0030, {g.spacing_mm[1], g.spacing_mm[0]});
    data.numbers(0x0028, 0x1052, {-1024}).numbers(0x0028, 0x1053, {1});
    std::string pixels;
    const std::int16_t* const from = volume.voxels<std::int16_t>().data() + static_cast<std::size_t>(k) * slice;
    for (std::size_t v = 0; v < slice; ++v)
      pixels += simplexseg::test::bytes_of_numbers(static_cast<std::uint16_t>(from[v] + 1024));
    data.raw(0x7fe0, 0x0010, "OW", pixels);
    std::ofstream(folder / (std::to_string(k) + ".dcm"), std::ios::binary)
        << simplexseg::test::dicom_file(data.bytes, kCt);
  }
}

using Image = itk::Image<std::int16_t, 3>;

double read_by_us(const fs::path& path) { return simplexseg::read_volume(path).value(100, 100, 100); }

double read_by_itk(const fs::path& path) {
  Image::Pointer image;
  if (fs::is_directory(path)) {
    const auto names = itk::GDCMSeriesFileNames::New();
    names->SetDirectory(path.string());
    const auto reader = itk::ImageSeriesReader<Image>::New();
    reader->SetImageIO(itk::GDCMImageIO::New());
    reader->SetFileNames(names->GetFileNames(names->GetSeriesUIDs().front()));
    reader->Update();
    image = reader->GetOutput();
  } else {
    const auto reader = itk::ImageFileReader<Image>::New();
    reader->SetFileName(path.string());
    reader->Update();
    image = reader->GetOutput();
  }
  return image->GetPixel({{100, 100, 100}});
}

struct Cost {
  double seconds = 0, cpu_seconds = 0, peak_mb = 0, value = 0;
};

/// Cost of f in a separate process.
Cost cost_of(const std::function<double()>& f) {
  int ends[2];
  if (::pipe(ends) != 0) std::abort();
  if (::fork() == 0) {
    const auto start = std::chrono::steady_clock::now();
    Cost cost;
    cost.value = f();
    cost.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    cost.peak_mb = static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;
    const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
    cost.cpu_seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    ::_exit(::write(ends[1], &cost, sizeof cost) == sizeof cost ? 0 : 1);
  }
  ::close(ends[1]);
  Cost cost;
  const bool complete = ::read(ends[0], &cost, sizeof cost) == sizeof cost;
  ::close(ends[0]);
  ::wait(nullptr);
  if (complete) return cost;
  std::fprintf(stderr, "bench_read: a reader failed\n");
  std::exit(1);
}

/// Least time and largest memory of the repetitions; other load on the machine only increases the time.
Cost bounds_of(const std::vector<Cost>& costs) {
  Cost bounds = costs.front();
  for (const Cost& cost : costs) {
    bounds.seconds = std::min(bounds.seconds, cost.seconds);
    bounds.cpu_seconds = std::min(bounds.cpu_seconds, cost.cpu_seconds);
    bounds.peak_mb = std::max(bounds.peak_mb, cost.peak_mb);
  }
  return bounds;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "bench_read: bench_read FOLDER [REPETITIONS]\n");
    return 2;
  }
  const fs::path folder = argv[1];
  const int repetitions = argc > 2 ? std::max(1, std::atoi(argv[2])) : 3;
  itk::NiftiImageIOFactory::RegisterOneFactory();
  itk::NrrdImageIOFactory::RegisterOneFactory();
  itk::MetaImageIOFactory::RegisterOneFactory();
  const char* const names[] = {"plain.nii",      "packed.nii.gz", "packed.nrrd", "packed.mha",
                               "series-12-bits", "series-16-bits"};  // ITK reads a.nii for a.nii.gz beside it
  for (const char* name : names) {
    cost_of([&] {
      const fs::path path = folder / name;
      if (fs::exists(path)) return 0.0;
      if (path.has_extension())
        simplexseg::write_volume(path, made());
      else
        write_series(path, made(), name == std::string("series-16-bits") ? 16 : 12);
      return 0.0;
    });
  }
  std::printf(
      "| file | ours, s | ITK, s | ratio | ours, s of CPU | ITK, s of CPU | ratio | ours, peak MB | ITK, peak MB |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  for (const char* name : names) {
    std::vector<Cost> ours, itk;
    for (int r = 0; r < repetitions; ++r) {
      ours.push_back(cost_of([&] { return read_by_us(folder / name); }));
      itk.push_back(cost_of([&] { return read_by_itk(folder / name); }));
      if (ours.back().value != itk.back().value) {
        std::fprintf(stderr, "bench_read: the readers differ in a voxel of %s\n", name);
        return 1;
      }
    }
    const Cost a = bounds_of(ours), b = bounds_of(itk);
    std::printf("| %s | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.0f | %.0f |\n", name, a.seconds, b.seconds,
                a.seconds / b.seconds, a.cpu_seconds, b.cpu_seconds, a.cpu_seconds / b.cpu_seconds, a.peak_mb,
                b.peak_mb);
    std::fflush(stdout);
  }
  return 0;
}
