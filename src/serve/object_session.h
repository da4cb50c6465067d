// SPDX-License-Identifier: Apache-2.0
// Segmentation of one object of one image by the prompts of a client, which come one at a time.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "field/box_prompt.h"
#include "gpu/backend.h"
#include "image/mask.h"
#include "io/scene/mesh_start.h"
#include "serve/drawn_mask.h"
#include "session/session.h"

namespace simplexseg {

/// Prompt of a client, in mm.
struct ObjectPrompt {
  struct Point {
    Eigen::Vector3d position_mm;
  };
  struct Scribble {
    std::vector<std::vector<Eigen::Vector3d>> paths_mm;  ///< at least one, each with at least one vertex
  };
  struct Lasso {
    std::vector<DrawnContour> contours;  ///< at least one
  };
  struct Box {
    BoxCorners corners;
    Eigen::Vector3d normal;  ///< unit normal of its slice
  };
  struct Object {
    std::shared_ptr<const LoadedStart> start;  ///< initial segmentation
  };
  bool inside = true;  ///< whether it marks the object; otherwise the background. Initial segmentations mark the object
  std::variant<Point, Scribble, Lasso, Box, Object> shape;
};

/// Prompts for a point, a mask and a box in an image, in the forms of the protocol. Each throws Error for a place
/// outside the image or an empty mask.
ObjectPrompt point_prompt(const VolumeGeometry& image, const Eigen::Vector3d& index, bool inside);
ObjectPrompt scribble_prompt(const Mask& drawn, bool inside);
ObjectPrompt lasso_prompt(const Mask& drawn, bool inside);
/// `box`: one voxel thick along at least one axis; clipped to the image.
ObjectPrompt box_prompt(const VolumeGeometry& image, const VoxelBox& box, bool inside);

/// Radius of the seed of a click, mm: as far as the image resembles the surroundings of the click, from the radius of a
/// mark (far_brush_radius_mm()) to `largest_mm`.
double seed_radius_mm(const Volume& image, const Eigen::Vector3d& centre_mm, double largest_mm);

/// One segmentation, driven like one in the window: the first prompt of the object starts a mesh, each further prompt
/// is a mark, stroke or lasso of its field, and the mesh runs until it settles. Prompts of the background wait until
/// the object has a prompt. One thread at a time may call it.
class ObjectSession {
 public:
  /// `largest_seed_mm`: of seed_radius_mm(); `threads`: threads for fields, 0 for all cores; `stopped`: makes solve()
  /// end within a few steps, with an incomplete object, as soon as it is true. Throws Error as Session::open().
  ObjectSession(Volume image, EngineChoice engine, double largest_seed_mm, int threads,
                const std::atomic<bool>& stopped);

  const Volume& image() const { return session_.volume(); }
  /// Adds a prompt as one unit of undo. Throws Error, with nothing changed, for a prompt that cannot be used.
  void add(ObjectPrompt prompt);
  /// Starts from this object, instead of all earlier prompts. One unit of undo. Throws Error for an empty mask.
  void start_from(Mask object);
  /// Computes object() from all prompts. Throws Error if the simulation fails.
  void solve();
  /// Restores object() and prompts from before the last add() or start_from(). Returns false if there is none, or it is
  /// older than the undo history of the session.
  bool undo();
  /// Removes object and prompts, and the undo history.
  void reset();
  /// Object after the last solve(), start_from() or undo(), on the grid of the image.
  const Mask& object() const { return object_; }

 private:
  /// Unit of undo: the state before it, and the commands that the session must undo.
  struct Interaction {
    int commands = 0;
    ItemId mesh;
    std::vector<ObjectPrompt> waiting;
    VoxelBox box;              ///< box of the object; empty: none
    std::vector<bool> voxels;  ///< object in this box
  };
  Interaction begin() const;
  void apply(const Command& command, Interaction& interaction);
  void apply_all(std::vector<ObjectPrompt> prompts, Interaction& interaction);
  void start(const ObjectPrompt& prompt, Interaction& interaction);
  void mark(const ObjectPrompt& prompt, Interaction& interaction);
  void add_stroke(MarkKind kind, const std::vector<Eigen::Vector3d>& path_mm, double radius_mm,
                  Interaction& interaction);
  void withdraw(const Interaction& interaction);
  template <class Work>
  void as_interaction(Work work);

  Session session_;
  const double largest_seed_mm_;
  const std::atomic<bool>& stopped_;
  ItemId mesh_ = 0;  ///< 0: no prompt of the object yet
  std::vector<ObjectPrompt> waiting_;
  std::vector<Interaction> history_;
  Mask object_;
};

}  // namespace simplexseg
