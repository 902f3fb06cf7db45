// Comma-separated values (RFC 4180): cells to write, records to read.
#ifndef CAIRN_CORE_CSV_H_
#define CAIRN_CORE_CSV_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Quoted if it holds a comma, a quote or the end of a line.
std::string CsvText(const std::string& text);

// Six significant digits; empty if the number is not finite.
std::string CsvNumber(double value);

// Reads the records of a text as spreadsheets and scripts write it. A cell in quotes may hold
// separators, ends of lines and doubled quotes. Blanks around a cell do not count. Lines end with
// LF, CR LF or CR; blank lines are skipped. The separator is a comma; it is a semicolon or a
// tabulator if the first line has one and no comma outside of quotes. A first line "sep=;", which
// Excel reads, names the separator and is no record.
class CsvReader {
 public:
  // The text must outlive the reader. Throws Error(kBadInput) for text in UTF-16.
  explicit CsvReader(std::string_view text);

  // Moves to the next record. Returns false after the last. Throws Error(kBadInput) for a quoted
  // cell that does not end or that text follows.
  bool Next();

  const std::vector<std::string>& cells() const { return cells_; }
  // The number in a cell of the record; nothing if the cell has none or not only a number. May be
  // infinite or NaN. The decimal mark may be a comma if the separator is another character.
  std::optional<double> Number(size_t cell_idx) const { return NumberOf(cells_[cell_idx]); }
  // The same of any text.
  std::optional<double> NumberOf(std::string text) const;
  int64_t line() const { return first_line_; }  // On which the record begins, from 1.
  char separator() const { return separator_; }

 private:
  void TakeStatedSeparator();
  std::string QuotedCell();
  std::string PlainCell();
  bool AtEndOfLine() const;
  void SkipBlanks();
  void SkipEndOfLine();

  std::string_view rest_;
  std::vector<std::string> cells_;
  int64_t line_ = 1;
  int64_t first_line_ = 0;
  char separator_ = ',';
};

}  // namespace cairn

#endif  // CAIRN_CORE_CSV_H_
