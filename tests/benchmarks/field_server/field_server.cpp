// SPDX-License-Identifier: Apache-2.0
// Evidence field as a process, for robots in other languages (scripts/prior3d/field.py):
//   field_server IMAGE THREADS [NETWORKS]
// NETWORKS: networks of the prior; default: those of the program. Reads commands from standard input, one a line, and
// writes to standard output. Positions are voxel indices, radii are in mm. Numbers after a line are binary, in the byte
// order of the machine, i fastest.
//   update N, then N lines KIND I J K RADIUS   solves the field for these marks. KIND: inside or outside. Writes the
//                                              line "field FIRST SIZE CELL EXPECTED", three numbers each for FIRST
//                                              (first cell), SIZE and CELL (voxels a cell), and float32 probabilities
//   restore, then float32 probabilities        replaces the field on its cells, for the object and the next update.
//                                              Writes the line "restored 1", or "restored 0" if it cannot
//   prior FIRST SIZE STEP SHARE, then float32 log odds
//                                              adds a prior to that of the next updates (ShapePrior), on a grid of SIZE
//                                              places whose first has the voxel index FIRST, STEP voxels apart; three
//                                              numbers each. SHARE: trust in it, 0 to 1; 0 removes it, without log odds
//   object                                     writes the object mask, a byte for each voxel of the image
//   brush KIND I J K                           writes the line "brush RADIUS": radius of the mark of a click
#include <algorithm>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/thread_pool.h"
#include "field/evidence_field.h"
#include "field/prior_network.h"
#include "field/shape_prior.h"
#include "io/platform/files.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

class FieldServer {
 public:
  FieldServer(Volume image, int threads, const EvidenceSettings& settings)
      : geometry_(image.geometry()),
        world_(geometry_.world_from_index()),
        pool_(threads),
        field_(
            std::move(image), [this](int jobs, const std::function<void(int)>& job) { pool_.run(jobs, job); },
            settings) {}

  /// Executes one command. Throws Error if it is unknown.
  void execute(const std::string& command) {
    if (command == "update") return update();
    if (command == "restore") return restore();
    if (command == "prior") return set_prior();
    if (command == "object") return write(field_.object().voxels);
    if (command == "brush") {
      const MarkKind kind = read_kind();
      std::cout << "brush " << field_.brush_mm(kind, read_place()) << '\n';
      return;
    }
    throw Error("'" + command + "'", "there is no such command", "use update, restore, prior, object or brush");
  }

 private:
  void update() {
    std::size_t count = 0;
    std::cin >> count;
    std::vector<Mark> marks(count);
    for (Mark& mark : marks) {
      mark.kind = read_kind();
      mark.position_mm = read_place();
      std::cin >> mark.radius_mm;
    }
    field_.update(marks);
    const VoxelBox& box = field_.box();
    std::cout << "field";
    for (const int first : box.first) std::cout << ' ' << first;
    for (const int size : box.size) std::cout << ' ' << size;
    for (const double cell : field_.cell()) std::cout << ' ' << cell;
    std::cout << ' ' << field_.report().expected_dice << '\n';
    write(field_.probability());
  }
  void restore() {
    std::cin.get();  // end of the line
    std::vector<float> probability(field_.box().voxel_count());
    std::cin.read(reinterpret_cast<char*>(probability.data()),
                  static_cast<std::streamsize>(probability.size() * sizeof(float)));
    const std::vector<Mark> marks(field_.marks().begin(), field_.marks().end());
    const CellSize cell = field_.cell();
    const VoxelBox box = field_.box();
    std::cout << "restored " << field_.restore(marks, cell, box, probability) << '\n';
  }
  void set_prior() {
    const Eigen::Vector3d first = read_place();
    auto prior = std::make_shared<ShapePrior>();
    prior->grid = geometry_;
    prior->grid.header = nullptr;
    prior->grid.origin_mm = first;
    for (int& size : prior->grid.size) std::cin >> size;
    for (int a = 0; a < 3; ++a) {
      double step = 1;
      std::cin >> step;
      prior->grid.spacing_mm[a] *= step;
    }
    std::cin >> prior->share;
    std::cin.get();  // end of the line
    if (prior->share <= 0) return field_.set_shape_prior({});
    prior->grid.validate("the prior");
    prior->log_odds.resize(prior->grid.voxel_count());
    std::cin.read(reinterpret_cast<char*>(prior->log_odds.data()),
                  static_cast<std::streamsize>(prior->log_odds.size() * sizeof(float)));
    prior->outside = *std::min_element(prior->log_odds.begin(), prior->log_odds.end());
    prior->bounds_mm = bounds_of(*prior);
    field_.set_shape_prior([prior](std::span<const Mark>) { return prior; });
  }
  /// Corners of the box (mm) around the places with positive log odds; the first place without any.
  static std::array<Eigen::Vector3d, 2> bounds_of(const ShapePrior& prior) {
    const auto [ni, nj, nk] = prior.grid.size;
    const Eigen::Affine3d world = prior.grid.world_from_index();
    std::array<Eigen::Vector3d, 2> bounds{world.translation(), world.translation()};
    bool any = false;
    std::size_t v = 0;
    for (int k = 0; k < nk; ++k)
      for (int j = 0; j < nj; ++j)
        for (int i = 0; i < ni; ++i, ++v) {
          if (prior.log_odds[v] <= 0) continue;
          const Eigen::Vector3d at = world * Eigen::Vector3d(i, j, k);
          bounds[0] = any ? bounds[0].cwiseMin(at) : at;
          bounds[1] = any ? bounds[1].cwiseMax(at) : at;
          any = true;
        }
    return bounds;
  }
  static MarkKind read_kind() {
    std::string kind;
    std::cin >> kind;
    if (kind == "inside") return MarkKind::Inside;
    if (kind == "outside") return MarkKind::Outside;
    throw Error("'" + kind + "'", "there is no such mark", "use inside or outside");
  }
  Eigen::Vector3d read_place() const {
    Eigen::Vector3d index;
    std::cin >> index[0] >> index[1] >> index[2];
    return world_ * index;
  }
  template <class Values>
  static void write(const Values& values) {
    std::cout.write(reinterpret_cast<const char*>(values.data()),
                    static_cast<std::streamsize>(values.size() * sizeof(values[0])));
  }

  VolumeGeometry geometry_;
  Eigen::Affine3d world_;
  ThreadPool pool_;
  EvidenceField field_;
};

}  // namespace
}  // namespace simplexseg

int main(int argc, char** argv) {
  using namespace simplexseg;
  if (argc < 3 || argc > 4) {
    std::cerr << "field_server IMAGE THREADS [NETWORKS]\n";
    return 2;
  }
  try {
    EvidenceSettings settings;
    PriorNetworks networks;
    if (argc == 4) {
      networks = PriorNetworks::parse(read_bytes(argv[3]));
      settings.networks = &networks;
    }
    std::cout.precision(17);
    FieldServer server(read_volume(argv[1]), std::stoi(argv[2]), settings);
    for (std::string command; std::cin >> command;) {
      server.execute(command);
      std::cout.flush();
    }
  } catch (const std::exception& error) {
    std::cerr << "field_server: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
