// Parses the URL of a PostgreSQL database.
#ifndef CAIRN_STORAGE_DATABASE_POSTGRES_ADDRESS_H_
#define CAIRN_STORAGE_DATABASE_POSTGRES_ADDRESS_H_

#include <string>
#include <utility>
#include <vector>

namespace cairn::postgres {

// The settings of libpq for one host: keywords and values.
using Settings = std::vector<std::pair<std::string, std::string>>;

// Splits a URL such as "postgresql://cairn@db1:5432,db2:5432/lund?sslmode=require" into the
// settings of each of its hosts, in order. Missing parts come from libpq's environment (PGHOST,
// PGUSER, PGPASSFILE, ...). Throws Error(kInvalidArgument) if libpq does not understand the URL, or
// if the URL holds a password, which everybody on the machine could read in the list of processes.
// No message quotes the URL.
std::vector<Settings> ParseAddress(const std::string& url);

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_DATABASE_POSTGRES_ADDRESS_H_
