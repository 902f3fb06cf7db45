// Cells of comma-separated values (RFC 4180).
#ifndef CAIRN_CORE_CSV_H_
#define CAIRN_CORE_CSV_H_

#include <string>

namespace cairn {

// Quoted if it holds a comma, a quote or the end of a line.
std::string CsvText(const std::string& text);

// Six significant digits; empty if the number is not finite.
std::string CsvNumber(double value);

}  // namespace cairn

#endif  // CAIRN_CORE_CSV_H_
