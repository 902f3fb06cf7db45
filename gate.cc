#include "http/service/fair_gate.cc"
#include "tests/http/fair_gate_test.cc"
