// Options of the tiles stage.
#ifndef CAIRN_ENGINE_TILES_TILES_OPTIONS_H_
#define CAIRN_ENGINE_TILES_TILES_OPTIONS_H_

namespace cairn {

struct TilesOptions {
  // At most this many tiles are searched, nearest to the prior first. A 50 m prior (3 sigma: a disc
  // of 200 m diameter) intersects at most 9 squares of 150 m.
  int max_tiles = 16;
  // A camera may be this much below the lowest or above the highest keyframe of the tiles, meters:
  // phones below a car's roof rig, balconies, steep streets.
  double height_margin_m = 8.0;
  // The share of the time until the query's deadline that loading missing tiles may take, [0, 1].
  // The nearest tile and a first part of its index are loaded in any case. The default is one half,
  // because searching the tiles then takes about as long as loading them.
  double deadline_share = 0.5;

  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_TILES_OPTIONS_H_
