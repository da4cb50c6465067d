// SPDX-License-Identifier: Apache-2.0
// Time and peak memory of reading a volume of 512 x 512 x 700 16-bit voxels, ours against ITK's own reader, each in a
// process of its own. bench_read FOLDER [REPETITIONS]: files of 0.4 GB are made in the folder where they are missing.
#include <itkImageFileReader.h>
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
#include <functional>
#include <vector>

#include "image/volume.h"
#include "io/volume_io.h"

namespace {

namespace fs = std::filesystem;
using simplexseg::Volume;

/// Smooth shapes and noise of a few values, as a CT has, so that it packs as one does.
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

struct Cost {
  double seconds = 0, peak_mb = 0;
};

/// Of f, in a child process; its memory without what the process has before.
Cost cost_of(const std::function<double()>& f) {
  int ends[2];
  if (::pipe(ends) != 0) std::abort();
  if (::fork() == 0) {
    const auto start = std::chrono::steady_clock::now();
    const double sum = f();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    const double said[3] = {seconds, static_cast<double>(usage.ru_maxrss) / 1024, sum};
    ::_exit(::write(ends[1], said, sizeof said) == sizeof said ? 0 : 1);
  }
  double said[3] = {0, 0, 0};
  if (::read(ends[0], said, sizeof said) != sizeof said) std::fprintf(stderr, "bench_read: a reader failed\n");
  ::close(ends[0]);
  ::close(ends[1]);
  ::wait(nullptr);
  return {said[0], said[1]};
}

Cost median_of(int repetitions, const std::function<double()>& f) {
  std::vector<Cost> costs;
  for (int r = 0; r < repetitions; ++r) costs.push_back(cost_of(f));
  std::sort(costs.begin(), costs.end(), [](const Cost& a, const Cost& b) { return a.seconds < b.seconds; });
  return costs[costs.size() / 2];
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
  const char* const names[] = {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"};
  for (const char* name : names) {
    if (cost_of([&] {
          if (!fs::exists(folder / name)) simplexseg::write_volume(folder / name, made());
          return 0.0;
        }).seconds < 0)
      return 1;
  }
  std::printf("| file | MB | ours s | ITK s | ratio | ours peak MB | ITK peak MB |\n|---|---|---|---|---|---|---|\n");
  for (const char* name : names) {
    const std::string path = (folder / name).string();
    const Cost ours = median_of(repetitions, [&] {
      const Volume volume = simplexseg::read_volume(path);
      return volume.value(100, 100, 100);
    });
    const Cost itk = median_of(repetitions, [&] {
      const auto reader = itk::ImageFileReader<itk::Image<std::int16_t, 3>>::New();
      reader->SetFileName(path);
      reader->Update();
      return static_cast<double>(reader->GetOutput()->GetPixel({{100, 100, 100}}));
    });
    std::printf("| %s | %.0f | %.2f | %.2f | %.2f | %.0f | %.0f |\n", name, double(fs::file_size(path)) / 1e6,
                ours.seconds, itk.seconds, ours.seconds / itk.seconds, ours.peak_mb, itk.peak_mb);
    std::fflush(stdout);
  }
  return 0;
}
