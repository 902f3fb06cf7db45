#include "tests/http/listener_test.cc"
