// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "image/paint_voxels.h"

namespace simplexseg {

/// Mask of an object that a segmentation network returned. Part of the scene and the log, so that neither a replay nor
/// a saved scene needs the network.
struct NetworkMask {
  PaintVoxels voxels;    ///< smallest box around the mask; inside or none
  std::string server;    ///< address of the server, without credentials
  std::string network;   ///< name of the network, as the server states it; empty: not stated
  std::string licence;   ///< of its weights, as the server states it; empty: not stated
  std::string identity;  ///< digest of the voxels, identity_of()
};

/// Digest of a mask and its grid: "network-" and 16 hexadecimal digits.
std::string identity_of(const PaintVoxels& voxels);

}  // namespace simplexseg
