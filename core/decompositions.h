// The canonical decompositions of characters. Private to core.
#ifndef CAIRN_CORE_DECOMPOSITIONS_H_
#define CAIRN_CORE_DECOMPOSITIONS_H_

namespace cairn {

struct Decomposition {
  char16_t whole;
  char16_t first;
  char16_t second;  // 0: none.
};

// Returns the decomposition of a character of the Basic Multilingual Plane, or null if there is
// none. The parts may decompose further. Hangul syllables, which follow a rule, are not in the
// table, and neither are the compatibility ideographs U+F900 to U+FAFF, which no file system
// decomposes.
const Decomposition* FindDecomposition(char32_t whole);

}  // namespace cairn

#endif  // CAIRN_CORE_DECOMPOSITIONS_H_
