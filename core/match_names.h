// Finds photos of one list in another, whose names may be written in another way.
#ifndef CAIRN_CORE_MATCH_NAMES_H_
#define CAIRN_CORE_MATCH_NAMES_H_

#include <string>
#include <vector>

namespace cairn {

struct NameMatches {
  std::vector<int> known_of_wanted;  // For each wanted name the index of the known one; -1: none.
  int num_inexact = 0;               // Wanted names that are equal to their known one only nearly.
  int inexact_example = -1;          // One of them.
};

// Finds each name of `wanted` in `known`. Equal names match first. Of the other names, those match
// that differ only in case (.JPG and .jpg), in the Unicode normal form (NFC and NFD) or in the kind
// of slash. If nothing matches by then, a name matches another one that ends with it as a path, as
// a.jpg and images/a.jpg do. If still nothing matches, the names are compared in these ways without
// their endings, as photos that were converted need it (a.HEIC, a.jpg and a). An ending is a dot
// and two to four letters or digits, of which one is a letter. Throws Error(kBadInput), with the
// names, if a name could be either of two.
NameMatches MatchNames(const std::vector<std::string>& wanted,
                       const std::vector<std::string>& known);

// An example of names that are not equal, for a message: "'a.HEIC' as 'a.jpg'". There must be one.
std::string InexactExample(const NameMatches& matches, const std::vector<std::string>& wanted,
                           const std::vector<std::string>& known);

// Up to three names for a message, quoted: "'a.jpg', 'b.jpg' and 27 others"; "none" without names.
std::string ExampleNames(const std::vector<std::string>& names);

}  // namespace cairn

#endif  // CAIRN_CORE_MATCH_NAMES_H_
