// Places a reconstruction on Earth by a robust similarity to known camera positions.
#ifndef CAIRN_INGEST_PLACE_GEOREGISTER_H_
#define CAIRN_INGEST_PLACE_GEOREGISTER_H_

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/geodesy.h"
#include "core/geoid.h"
#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "ingest/place/picture_up.h"
#include "ingest/place/placement_accuracy.h"

namespace cairn {

// A known camera position.
struct CameraPosition {
  std::string image_name;
  Geodetic position;        // Georegister expects ellipsoidal heights.
  double accuracy_m = 5.0;  // 68 % radius.
  bool has_height = true;   // If false, `position` has some height near that of the street.
  std::optional<HeightReference> height_reference = {};  // If the source of the height states it.
};

// Reads a CSV of positions (core/csv.h, position_columns.h): image, lat_deg, lon_deg, h_m,
// optionally accuracy_m. Leaves out rows without a position, and counts equal rows of a photo once.
// Throws Error(kBadInput) that names file, line and column, and if there is no position, or if a
// photo has two. Rows without an accuracy get the default.
std::vector<CameraPosition> ReadCameraPositions(const std::string& path,
                                                double default_accuracy_m = 5.0);

// Reads such a table and gives the positions the names of the photos that MatchNames finds for
// them; leaves out the others. Adds sentences to `notes` that say how many are left out, and how
// many names are not equal. Throws as ReadCameraPositions, and Error(kBadInput) if two rows are of
// one photo, and, with names of both, if no row is of a photo.
std::vector<CameraPosition> ReadPositionsOfPhotos(const std::string& path,
                                                  const std::vector<std::string>& photo_names,
                                                  std::vector<std::string>* notes,
                                                  double default_accuracy_m = 5.0);

// Gives the positions the names of the images that MatchNames (core/match_names.h) finds for them.
// Returns a sentence if there are positions without an image. Throws Error(kBadInput), with names
// of both, if it finds none for all of them, or cannot decide.
std::optional<std::string> NameAfterImages(const Reconstruction& reconstruction,
                                           std::vector<CameraPosition>* positions);

// The GPS priors of the reconstruction's images. `accuracy_m` is for images whose source states no
// accuracy. Heights are unchanged; EXIF heights are above mean sea level.
std::vector<CameraPosition> GpsPositions(const Reconstruction& reconstruction, double accuracy_m);

// Converts heights to heights above the ellipsoid. They are above `chosen`, else above what the
// position states, else above `usual`. Throws as WithEllipsoidalHeight.
void MakeHeightsEllipsoidal(std::optional<HeightReference> chosen, HeightReference usual,
                            std::vector<CameraPosition>* positions);

// Where up comes from.
enum class UpSource {
  kAuto,       // All that is known, weighed by likelihood.
  kPositions,  // The positions alone.
  kPhotos,     // The orientations in the photos' EXIF.
  kTop,        // The top of every stored picture is up;
  kLeft,       // its left side, as in phones held upright;
  kRight,      // its right side;
  kBottom,     // its bottom.
  kDown,       // Every photo looks straight down.
};

struct GeoregisterOptions {
  UpSource up = UpSource::kAuto;
  // With kAuto, a direction is refused unless it is this many times as likely as the next.
  // A map on its side answers with wrong poses, and a refusal costs one option.
  double least_up_odds = 20.0;
  // Standard deviation in radians of the prior that photos are held level, each in one of the ways
  // of PictureUp; 0 switches the prior off, as kPositions does. The prior is needed because camera
  // positions along a line leave the roll about the line free, and because GPS heights are poor.
  double upright_sigma_rad = 0.1;
  // A fit is refused if its median residual exceeds one of these limits: in units of the accuracy,
  // or in meters. The default in meters is three times the stated accuracy, if that is more.
  double max_median_residual_sigmas = 3.0;
  double max_median_residual_m = 20.0;

  void Validate() const;
};

// How up was found.
struct UpReport {
  std::string source;  // For people; what told the direction from the next best.
  double odds = 0.0;   // How many times as likely as the next best; 0 if nothing was compared.
  std::array<int, kPictureUps.size()> num_images = {};  // Held in each way of PictureUp.
};

struct Georegistration {
  Sim3d ecef_from_world;
  // No positions place the session, but the answers of a map; then only `ecef_from_world`
  // and the accuracies are set.
  bool is_by_map = false;
  UpReport up;
  int num_positions = 0;           // Positions whose image is in the reconstruction.
  int num_inliers = 0;             // Positions within six times their accuracy.
  double stated_accuracy_m = 0.0;  // Median of the positions' accuracies.
  double median_residual_m = 0.0;
  double max_residual_m = 0.0;
  std::vector<double> residuals_m;  // One for each used position, in input order.
  std::string worst_image;          // The one of max_residual_m.
  // Positions without agreement that would agree if latitude or longitude had the other sign.
  int num_sign_errors = 0;
  // Sentences for the summary about faults of the positions; Georegister adds none.
  std::vector<std::string> notes;
  // How far the placed reconstruction is from its true place; positions of neighboring names count
  // as taken one after the other.
  PlacementAccuracy accuracy;
};

// For each image of a reconstruction, how to turn upright the pixels in which its keypoints lie:
// the EXIF orientation, or 1 if the pixels were turned before. Empty where no photo was found.
using ImageOrientations = std::vector<std::optional<int>>;

// `orientations` has a member for each image, or is empty if none is known. Throws
// Error(kBadInput), with counts and residuals, if too few positions match, if the positions
// do not determine a similarity (all at one place), if the fit is bad, or if it is not certain
// which way is up.
Georegistration Georegister(const Reconstruction& reconstruction,
                            const std::vector<CameraPosition>& positions,
                            const GeoregisterOptions& options,
                            const ImageOrientations& orientations = {});

// Sentences about the positions that disagree; none if all agree.
std::vector<std::string> NotesOnOutliers(const Georegistration& georegistration);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_GEOREGISTER_H_
