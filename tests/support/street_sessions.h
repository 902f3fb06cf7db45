// Sessions of a short synthetic street.
#ifndef CAIRN_TESTS_SUPPORT_STREET_SESSIONS_H_
#define CAIRN_TESTS_SUPPORT_STREET_SESSIONS_H_

#include <string>

#include "ingest/ingest_options.h"
#include "support/reconstruction_builder.h"

namespace cairn::testing {

// 16 photos.
inline StreetWorldOptions ShortStreet() {
  StreetWorldOptions options;
  options.length_m = 45.0;
  options.num_landmarks = 800;
  return options;
}

// Options with a codebook that is trained quickly.
inline IngestOptions SessionNamed(const std::string& name) {
  IngestOptions options;
  options.session_name = name;
  options.source = "a test";
  options.codebook.max_training_descriptors = 1000;
  return options;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_STREET_SESSIONS_H_
