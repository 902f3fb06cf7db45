// Includes httplib's client for tests in a way that is compatible with Eigen.
#ifndef CAIRN_TESTS_HTTP_PLAIN_HTTP_H_
#define CAIRN_TESTS_HTTP_PLAIN_HTTP_H_

// Eigen must come first: httplib includes <resolv.h>, which defines a macro with a name that Eigen
// uses.
// clang-format off
#include <Eigen/Core>
#include <httplib.h>
// clang-format on

#endif  // CAIRN_TESTS_HTTP_PLAIN_HTTP_H_
