// Consistency checks of tiles. Private to storage.
#ifndef CAIRN_STORAGE_TILE_TILE_CHECKS_H_
#define CAIRN_STORAGE_TILE_TILE_CHECKS_H_

#include <string>

#include "storage/tile/tile.h"

namespace cairn {

inline constexpr int kMaxCodeSize = 64;            // Bytes of a descriptor code.
inline constexpr int kMaxPositionSteps = 1 << 20;  // Positions lie in [-2^20, 2^20) steps: 4096 m.

// Returns a description of the first inconsistency, or an empty string. Takes time linear in the
// tile's size.
std::string FindTileProblem(const Tile& tile);

// The same of the histories of its landmarks, whose number must be set.
std::string FindHistoryProblem(const Tile& tile);

// True if the transform is finite and its quaternion of unit norm.
bool IsPose(const Rigid3d& pose);

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_CHECKS_H_
