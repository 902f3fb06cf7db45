#include "tests/http/connection_test.cc"
