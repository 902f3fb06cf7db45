#include "ingest/place/position_columns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "ingest/place/georegister.h"
#include "ingest/place/position_checks.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Optional;

std::vector<CameraPosition> Read(const std::string& text) {
  const testing::TempDir dir;
  std::ofstream(dir.File("positions.csv")) << text;
  return ReadCameraPositions(dir.File("positions.csv"));
}

std::string RefusalOf(const std::string& text) {
  try {
    Read(text);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kBadInput);
    return e.what();
  }
  return "no error";
}

void ExpectPosition(const CameraPosition& position, const std::string& name, double lat_deg,
                    double lon_deg, double h_m) {
  EXPECT_EQ(position.image_name, name);
  EXPECT_NEAR(position.position.lat_deg(), lat_deg, 1e-9);
  EXPECT_NEAR(position.position.lon_deg(), lon_deg, 1e-9);
  EXPECT_DOUBLE_EQ(position.position.h_m, h_m);
}

TEST(CameraPositionsOfPrograms, ExiftoolWritesNumbers) {
  const auto positions = Read(
      "SourceFile,GPSLatitude,GPSLongitude,GPSAltitude,FocalLength\n"
      "./01.jpg,55.6981666666667,-13.1953888888889,37.5,4.2\n"
      "./02.jpg,,,,4.2\n");
  ASSERT_EQ(positions.size(), 1u);
  ExpectPosition(positions[0], "./01.jpg", 55.6981666666667, -13.1953888888889, 37.5);
}

// Survey receivers write the height above the sea as well.
TEST(CameraPositionsOfPrograms, AHeightThatNamesTheEllipsoidCountsBeforeVagueOnes) {
  for (const std::string header :
       {"Name,Elevation,Longitude,Latitude,Ellipsoidal height", "Name,altitude,lon,lat,HAE",
        "Name,height (m),lon,lat,ellipsoid_height"}) {
    const auto positions = Read(header + "\n01.jpg,37.0,13.195,55.698,72.7\n");
    ASSERT_EQ(positions.size(), 1u) << header;
    ExpectPosition(positions[0], "01.jpg", 55.698, 13.195, 72.7);
  }
}

TEST(CameraPositionsOfPrograms, ExiftoolWritesDegreesAndMinutes) {
  const auto positions = Read(
      "SourceFile,EXIF:GPSAltitude,GPSLatitude,GPSLongitude\n"
      "a.jpg,37 m Above Sea Level,\"55 deg 41' 53.40\"\" N\",\"13 deg 11' 43.40\"\" W\"\n"
      "b.jpg,2.5 m Below Sea Level,\"33 deg 30' 0.00\"\" S\",\"13 deg 30' 0.00\"\" E\"\n");
  ASSERT_EQ(positions.size(), 2u);
  ExpectPosition(positions[0], "a.jpg", 55.6981666666667, -(13.0 + 11.0 / 60 + 43.4 / 3600), 37.0);
  ExpectPosition(positions[1], "b.jpg", -33.5, 13.5, -2.5);
}

// Unsigned angles of exiftool's group EXIF: the hemisphere has a column of its own.
TEST(CameraPositionsOfPrograms, HemispheresHaveColumns) {
  const auto positions = Read(
      "SourceFile,GPSLatitudeRef,GPSLatitude,GPSLongitudeRef,GPSLongitude,GPSAltitude\n"
      "a.jpg,South,33.5,W,70.5,570\n"
      "b.jpg,S,-33.5,E,70.5,570\n");
  ExpectPosition(positions.at(0), "a.jpg", -33.5, -70.5, 570.0);
  ExpectPosition(positions.at(1), "b.jpg", -33.5, 70.5, 570.0);
}

TEST(CameraPositionsOfPrograms, HemispheresHaveColumnsOfManyNames) {
  for (const auto& [lat_ref, lon_ref] : std::vector<std::pair<std::string, std::string>>{
           {"LatitudeRef", "LongitudeRef"},
           {"N/S", "E/W"},
           {"lat_ref", "lon_ref"},
           {"North/South", "East/West"},
           {"GPS Latitude Ref", "GPS Longitude Ref"}}) {
    const auto positions = Read("image,lat," + lat_ref + ",lon," + lon_ref +
                                ",alt\na,33.5,S,70.5,West,570\nb,33.5,n,70.5,E,570\n");
    ExpectPosition(positions.at(0), "a", -33.5, -70.5, 570.0);
    ExpectPosition(positions.at(1), "b", 33.5, 70.5, 570.0);
  }
}

TEST(CameraPositionsOfPrograms, HemispheresUnderAnUnknownNameAreRefused) {
  EXPECT_THAT(RefusalOf("image,lat,half,lon,alt\na,33.5,S,70.5,570\nb,33.5,,70.5,570\n"),
              AllOf(HasSubstr("column 'half'"), HasSubstr("call it lat_ref")));
  EXPECT_THAT(RefusalOf("image,lat,lon,side,alt\na,33.5,70.5,east,570\nb,33.5,70.5,west,570\n"),
              AllOf(HasSubstr("column 'side'"), HasSubstr("call it lon_ref")));
  // Nothing changes, or the letters are directions of something else.
  EXPECT_EQ(Read("image,lat,half,lon,alt\na,33.5,N,70.5,570\n").size(), 1u);
  EXPECT_EQ(Read("image,lat,lon,view,alt\na,3,7,S,570\nb,3,7,E,570\n").size(), 2u);
}

TEST(CameraPositionsOfPrograms, HemispheresAreOneOfTwo) {
  EXPECT_THAT(RefusalOf("image,lat,lat_ref,lon,alt\na,33.5,E,70.5,570\n"),
              HasSubstr("line 2: column lat_ref: 'E' is neither N nor S"));
}

TEST(CameraPositionsOfPrograms, MetashapeAndSpreadsheets) {
  const auto metashape =
      Read("#Label,X/Longitude,Y/Latitude,Z/Altitude,Accuracy\nIMG_1.JPG,8.5,47.25,400.5,0.3\n");
  ExpectPosition(metashape.at(0), "IMG_1.JPG", 47.25, 8.5, 400.5);
  EXPECT_EQ(metashape[0].accuracy_m, 0.3);
  const auto spreadsheet =
      Read("File Name;Latitude [deg];Longitude (deg);Height (m)\r\nIMG_1.JPG;47,25;8,5;400,5\r\n");
  ExpectPosition(spreadsheet.at(0), "IMG_1.JPG", 47.25, 8.5, 400.5);
}

TEST(CameraPositionsOfPrograms, MetashapeStatesItsCoordinateSystemFirst) {
  const auto positions = Read(
      "# CoordinateSystem: GEOGCS[\"WGS 84\",DATUM[\"World Geodetic System 1984\"]]\n"
      "#Label\tX/Longitude\tY/Latitude\tZ/Altitude\nIMG_1.JPG\t8.5\t47.25\t400.5\n");
  ExpectPosition(positions.at(0), "IMG_1.JPG", 47.25, 8.5, 400.5);
  EXPECT_THAT(RefusalOf("# nothing"), HasSubstr("the header is missing"));
  EXPECT_THAT(RefusalOf("# x\nimage,lat,lon,alt\na,b,8,400\n"), HasSubstr("line 3"));
}

TEST(CameraPositionsOfPrograms, OtherUnitsAreRefused) {
  EXPECT_THAT(RefusalOf("image,Latitude (rad),lon,alt\na,0.8,8,400\n"),
              HasSubstr("no column 'lat_deg'"));
}

TEST(CameraPositionsOfPrograms, NamesOfHeightsStateTheirReference) {
  const auto reference_of = [](const std::string& name) {
    return Read("image,lat,lon," + name + "\na,47,8,400\n").at(0).height_reference;
  };
  for (const char* name :
       {"Altitude (MSL)", "hmsl", "h_msl_m", "OrthoHeight", "height_orthometric", "AMSL",
        "Elevation [m a.s.l.]", "altitude above sea level (meters)", "alt_m_msl"}) {
    EXPECT_EQ(reference_of(name), HeightReference::kMeanSeaLevel) << name;
  }
  for (const char* name : {"hae", "height_ellipsoidal", "Altitude (WGS84)", "h_ell [m]"}) {
    EXPECT_EQ(reference_of(name), HeightReference::kEllipsoid) << name;
  }
  for (const char* name : {"h_m", "altitude", "GPSAltitude", "Height (m)", "h"}) {
    EXPECT_EQ(reference_of(name), std::nullopt) << name;
  }
}

TEST(CameraPositionsOfPrograms, AHeightWithAReferenceCountsBeforeVagueOnes) {
  const auto positions =
      Read("image,lat,lon,altitude,h_msl,altitude_ft\na,47,8,400,350,1148\nb,47,8,,,\n");
  EXPECT_EQ(positions.at(0).position.h_m, 350.0);
  // A row without a height gets the median of the others, which is of their kind.
  EXPECT_EQ(positions.at(1).height_reference, HeightReference::kMeanSeaLevel);
}

TEST(CameraPositionsOfPrograms, PlaceholdersOfHeightsStayImpossible) {
  const auto positions = Read("image,lat,lon,h\na,47,8,-32768\nb,47,8,1e6\n");
  EXPECT_LT(positions.at(0).position.h_m, kLowestPlaceM);
  EXPECT_GT(positions.at(1).position.h_m, kHighestPlaceM);
}

TEST(CameraPositionsOfPrograms, HeightsInFeetAreRefusedByName) {
  for (const std::string name : {"Altitude (ft)", "altitude_feet", "h_msl_ft", "EXIF:alt [US ft]",
                                 "altitude_above_seaLevel(feet)"}) {
    EXPECT_THAT(RefusalOf("image,lat,lon," + name + "\na,47,8,400\n"),
                HasSubstr("the heights of the column '" + name + "' are not in meters"));
  }
}

TEST(CameraPositionsOfPrograms, TheRefusalNamesTheColumnsThatThereAre) {
  for (const std::string name : {"height above ground", "geoid height", "Z", "msl hae"}) {
    EXPECT_THAT(RefusalOf("image,lat,lon," + name + "\na,47,8,400\n"),
                AllOf(HasSubstr("no column 'h_m'"), HasSubstr("got image, lat, lon, " + name)));
  }
}

TEST(CameraPositionsOfPrograms, OfTwoColumnsOfOneNameNoneCounts) {
  EXPECT_THAT(RefusalOf("image,lat,lon,lat,lon,alt\na,47,8,48,9,400\n"),
              HasSubstr("several columns 'lat'; leave one"));
  EXPECT_THAT(RefusalOf("image,image,lat,lon,alt\na,b,47,8,400\n"), HasSubstr("'image'"));
}

TEST(CameraPositionsOfPrograms, OfTwoNamesForACoordinateTheLogSaysWhichCounts) {
  ::testing::internal::CaptureStderr();
  const auto positions = Read("image,lat,lon,latitude,longitude,alt\na,47,8,48,9,400\n");
  const std::string log = ::testing::internal::GetCapturedStderr();
  ExpectPosition(positions.at(0), "a", 48.0, 9.0, 400.0);
  EXPECT_THAT(log, HasSubstr("may be lat_deg, 'latitude' counts, and 'lat' does not"));
  EXPECT_THAT(log, HasSubstr("may be lon_deg, 'longitude' counts, and 'lon' does not"));
}

TEST(CameraPositionsOfPrograms, HeightsOfPicturesAreNoHeights) {
  const auto positions = Read("image,width,height,lat,lon,alt\na,4032,3024,47,8,400\n");
  EXPECT_EQ(positions.at(0).position.h_m, 400.0);
  EXPECT_THAT(RefusalOf("image,width,height,lat,lon\na,4032,3024,47,8\n"),
              HasSubstr("no column 'h_m'"));
}

TEST(CameraPositionsOfPrograms, SignsOfExiftoolsCompositeCount) {
  const auto positions = Read(
      "SourceFile,EXIF:GPSLatitude,EXIF:GPSLongitude,EXIF:GPSAltitude,EXIF:GPSAltitudeRef,"
      "Composite:GPSLatitude,Composite:GPSLongitude,EXIF:GPSHPositioningError\n"
      "a.jpg,33.5,70.5,12,1,-33.5,-70.5,4.7 m\nb.jpg,33.5,70.5,undef,0,-33.5,-70.5,inf\n");
  ExpectPosition(positions.at(0), "a.jpg", -33.5, -70.5, -12.0);
  EXPECT_EQ(positions[0].accuracy_m, 4.7);
  EXPECT_FALSE(positions.at(1).has_height);
  EXPECT_EQ(positions[1].accuracy_m, 5.0);
}

TEST(CameraPositionsOfPrograms, OwnNamesComeFirst) {
  const auto positions = Read("latitude,lat_deg,longitude,lon_deg,name,image,h_m\n1,2,3,4,a,b,5\n");
  ExpectPosition(positions.at(0), "b", 2.0, 4.0, 5.0);
}

TEST(CameraPositionsOfPrograms, HeightsMayBeMissing) {
  const auto positions = Read("image,lat,lon,alt\na,47,8,400\nb,47,8,\nc,47,8,-\n");
  EXPECT_TRUE(positions.at(0).has_height);
  EXPECT_FALSE(positions.at(1).has_height);
  EXPECT_FALSE(positions.at(2).has_height);
  EXPECT_THAT(RefusalOf("image,lat,lon\na,47,8\n"), HasSubstr("no column 'h_m'"));
}

TEST(CameraPositionsOfPrograms, EmptyAccuraciesAreNone) {
  EXPECT_EQ(Read("image,lat,lon,alt,accuracy_m\na,47,8,400,\n").at(0).accuracy_m, 5.0);
}

TEST(CameraPositionsOfPrograms, HalfAPositionIsRefused) {
  EXPECT_THAT(RefusalOf("image,lat,lon,alt\na,47,,400\n"), HasSubstr("column lon_deg: ''"));
}

TEST(CameraPositionsOfPrograms, ARowInPlaceOfTheHeaderIsNoticed) {
  EXPECT_THAT(RefusalOf("a.jpg,47,8,400\nb.jpg,47,8,400\n"),
              HasSubstr("this line looks like a position"));
}

TEST(CameraPositionsOfPrograms, NamesOfColumnsOfPix4dAndSurveyors) {
  for (const char* header :
       {"imagename,latitude [decimal degrees],longitude [decimal degrees],altitude [meter]",
        "Image File,Latitude_DD,Longitude_DD,Ellipsoidal height", "path,lat,lon,HAE",
        "image_path,lat,lon,ele"}) {
    ExpectPosition(Read(std::string(header) + "\na,47,8,400\n").at(0), "a", 47.0, 8.0, 400.0);
  }
}

TEST(CameraPositionsOfPrograms, NothingHasManyNames) {
  const auto positions =
      Read("image,lat,lon,alt,accuracy_m\na,NA,nan,None,\nb,47,8,N/A,null\nc,47,8,NaN,NA\n");
  ASSERT_EQ(positions.size(), 2u);
  EXPECT_FALSE(positions[0].has_height);
  EXPECT_EQ(positions[1].accuracy_m, 5.0);
}

TEST(CameraPositionsOfPrograms, CommentsMayStandAnywhere) {
  const auto positions = Read(
      "#Label,lat,lon,alt,error\n# May\n#1.jpg,47,8,400,0\n# Markers "
      "(1)\n#Label,lat,lon,alt,error\n"
      "# Total Error,,,,0.12\n");
  ASSERT_EQ(positions.size(), 1u);
  EXPECT_EQ(positions[0].image_name, "#1.jpg");
}

TEST(CameraPositionsOfPrograms, ADelimiterAtTheEndDoesNotCount) {
  EXPECT_EQ(Read("sep=;\nimage;lat;lon;alt\na;47;8;400;\nb;47;8;400\n").size(), 2u);
  EXPECT_EQ(Read("image,lat,lon,alt,\na,47,8,400,,\nb,47,8,400\n").size(), 2u);
  EXPECT_THAT(RefusalOf("image,lat,lon,alt\na,47,8,400,5\n"), HasSubstr("5 columns"));
}

TEST(CameraPositionsOfPrograms, SignsOfTypographersAndUnitsWithCommas) {
  const auto positions = Read(
      "image;lat;lon;alt\na\u00a0;\u221247,5\u00b0;8,5\u00a0W;37,5\u202fm\nb;47;8;\u2212370/100\n");
  ExpectPosition(positions.at(0), "a", -47.5, -8.5, 37.5);
  ExpectPosition(positions.at(1), "b", 47.0, 8.0, -3.7);
}

TEST(CameraPositionsOfPrograms, TheLetterOIsEastOrWest) {
  EXPECT_NEAR(Read("image,lat,lon,alt\na,47,8 O,4\nb,47,8 W,4\n")[0].position.lon_deg(), 8, 1e-9);
  EXPECT_NEAR(Read("image,lat,lon,alt\na,47,8 O,4\nb,47,8 E,4\n")[0].position.lon_deg(), -8, 1e-9);
  EXPECT_NEAR(Read("image,lat,lon,lon_ref,alt\na,47,8,Ouest,4\n")[0].position.lon_deg(), -8, 1e-9);
  EXPECT_THAT(RefusalOf("image,lat,lon,alt\na,47,8 O,4\n"),
              HasSubstr("'O' may be east (Ost) or west (Ouest, Oeste)"));
  EXPECT_THAT(RefusalOf("image,lat,lon,lon_ref,alt\na,47,8,O,4\n"), HasSubstr("column lon_ref"));
}

TEST(CameraPositionsOfPrograms, APhotoHasOnePosition) {
  EXPECT_EQ(Read("image,lat,lon,alt\na,47,8,400\na,47.0,8,400\n").size(), 1u);
  EXPECT_THAT(RefusalOf("image,lat,lon,alt\na,47,8,400\nb,47,8,400\na,47,8,401\n"),
              AllOf(HasSubstr("line 4"), HasSubstr("the photo a has another position")));
}

TEST(CameraPositionsOfPrograms, WithoutAColumnOfHeightsTheRefusalSaysWhatToDo) {
  EXPECT_THAT(RefusalOf("image,lat,lon\na,47,8\n"), HasSubstr("--camera-height"));
}

TEST(AngleDeg, ReadsSignsOfAllKinds) {
  EXPECT_THAT(AngleDeg("55\u00b030'36\"N", "NS"), Optional(55.51));
  EXPECT_THAT(AngleDeg("S 55\u00b030.6\u2032", "NS"), Optional(-55.51));
  EXPECT_THAT(AngleDeg("-8:30", "EW"), Optional(-8.5));
  EXPECT_THAT(AngleDeg("8.5 w", "EW"), Optional(-8.5));
  EXPECT_THAT(AngleDeg("55d 30m 36s", "NS"), Optional(55.51));
  EXPECT_THAT(AngleDeg("S 55d 30m 36s", "NS"), Optional(-55.51));
}

TEST(AngleDeg, RefusesOtherTexts) {
  for (const char* text :
       {"", "N", "north", "55 60 N", "55 -1 N", "1 2 3 4", "55x", "5 E", "-5 N", "nan", "1e999",
        "55 deg 41' 53.40\" Q", "55.698.167", "55.5 30", "55 30s"}) {
    EXPECT_EQ(AngleDeg(text, "NS"), std::nullopt) << text;
  }
}

TEST(HeightM, ReadsUnits) {
  EXPECT_THAT(HeightM("37.5 m Above Sea Level"), Optional(37.5));
  EXPECT_THAT(HeightM("37.5 m"), Optional(37.5));
  EXPECT_THAT(HeightM("3750/100"), Optional(37.5));
  EXPECT_EQ(HeightM("37.5/0"), std::nullopt);
  EXPECT_EQ(HeightM("37.5 ft"), std::nullopt);
  EXPECT_EQ(HeightM("high"), std::nullopt);
}

}  // namespace
}  // namespace cairn
