// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "mesh/simplex_mesh.h"

namespace simplexseg::python {

/// simplexseg.Mesh: immutable; the arrays that view it share the ownership.
struct Surface {
  std::shared_ptr<const SimplexMesh> mesh;

  explicit Surface(SimplexMesh made) : mesh(std::make_shared<const SimplexMesh>(std::move(made))) {}
};

}  // namespace simplexseg::python
