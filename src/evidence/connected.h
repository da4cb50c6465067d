// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace simplexseg {

/// Clears in `set` all voxels that are not connected, over faces of set voxels, to one that is 1 in `start`, too. Both
/// are 0 or 1.
void keep_connected(std::vector<std::uint8_t>& set, std::span<const std::uint8_t> start,
                    const std::array<int, 3>& size);

}  // namespace simplexseg
