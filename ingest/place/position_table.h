// Reads CSV files of positions. Private to ingest/place.
#ifndef CAIRN_INGEST_PLACE_POSITION_TABLE_H_
#define CAIRN_INGEST_PLACE_POSITION_TABLE_H_

#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/csv.h"
#include "core/geodesy.h"
#include "core/geoid.h"

namespace cairn {

// One file with a header. Its columns may have the names that other programs give them
// (position_columns.h). Its errors name the file, the line and the column.
class PositionTable {
 public:
  // `required` has h_m. Throws Error(kBadInput) if one of these columns is missing, or occurs
  // twice; the message lists them, `accuracy_m`, which is optional, and the header. Throws as
  // RequireKnownHemispheres, too. Logs which columns count if others may mean the same.
  PositionTable(const std::string& path, std::initializer_list<const char*> required);
  PositionTable(const PositionTable&) = delete;  // rows_ views text_.

  // Moves to the next row; false after the last. Rows that begin with '#' and have no position are
  // comments.
  bool NextRow();

  bool Has(const char* name) const;  // False if the cell stands for nothing.
  const std::string& Text(const char* name) const { return cells_[ColumnOf(name)]; }
  double Number(const char* name) const;  // Finite.

  // The columns lat_deg, lon_deg and h_m, with 0 for no height; `what` names the thing that is
  // there.
  Geodetic Position(const std::string& what) const;
  double AccuracyOr(double default_m) const;  // accuracy_m, which must be positive.
  // The reference that the name of the column h_m states.
  std::optional<HeightReference> height_reference() const { return height_reference_; }
  bool HasAltitudesOfExif() const { return has_altitudes_of_exif_; }  // IsAltitudeOfExif.

  [[noreturn]] void Throw(const std::string& what) const;

 private:
  size_t ColumnOf(const char* name) const { return column_of_name_.find(name)->second; }
  // Takes the column that counts if there is one.
  bool TakeColumn(const char* name, const std::vector<std::string>& header);
  void TakeHeightsFrom(const std::string& column_name);
  void TakeCells();
  bool IsComment() const;
  void RequireColumns() const;
  [[noreturn]] void ThrowNoColumn(const char* name, std::initializer_list<const char*> required,
                                  const std::vector<std::string>& header) const;
  std::string AngleText(const char* name, std::string_view hemispheres) const;
  double Angle(const char* name, const char* ref_name, const char* hemispheres) const;
  bool IsNegative(const char* ref_name, const char* hemispheres) const;
  double Height() const;
  double Meters(const char* name) const;  // With or without the unit.

  std::string path_;
  std::string text_;
  CsvReader rows_;
  std::vector<std::string> cells_;  // Of the row, with plain signs but in names.
  std::optional<char> meaning_of_o_;
  std::map<std::string, size_t, std::less<>> column_of_name_;
  size_t num_columns_ = 0;  // Of the header, without empty cells at its end.
  std::optional<HeightReference> height_reference_;
  bool has_altitudes_of_exif_ = false;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_POSITION_TABLE_H_
