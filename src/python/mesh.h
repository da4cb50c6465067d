// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "mesh/simplex_mesh.h"

namespace simplexseg::python {

/// simplexseg.Mesh: immutable, and shared with the arrays that look into it.
struct Surface {
  std::shared_ptr<const SimplexMesh> mesh;

  explicit Surface(SimplexMesh made) : mesh(std::make_shared<const SimplexMesh>(std::move(made))) {}
};

}  // namespace simplexseg::python
