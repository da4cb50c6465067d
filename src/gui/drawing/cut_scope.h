// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <span>

namespace simplexseg {

class Program;

/// Coefficients of at most kCutPlanes planes; each removes where it is above 0 (ClipPlane::equation()).
using CutEquations = std::span<const Eigen::Vector4f>;

/// Applies cutting planes to what is drawn by a program with the uniform `cut`, during the lifetime of the scope.
class CutScope {
 public:
  CutScope(const Program& program, CutEquations planes);
  ~CutScope();
  CutScope(const CutScope&) = delete;
  CutScope& operator=(const CutScope&) = delete;

 private:
  unsigned count_;
};

}  // namespace simplexseg
