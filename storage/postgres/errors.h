// Converts failures of PostgreSQL to cairn::Error.
#ifndef CAIRN_STORAGE_POSTGRES_ERRORS_H_
#define CAIRN_STORAGE_POSTGRES_ERRORS_H_

#include <libpq-fe.h>

#include <string>
#include <string_view>

#include "core/error.h"

namespace cairn::postgres {

// Returns true if the server or the connection is gone or going, so that nothing more can be asked
// over the connection (classes 08 and 57P of SQLSTATE, too many connections).
bool EndsConnection(std::string_view sqlstate);

// Returns the error of a failed statement, with the server's message and what to do about it:
//  - kUnavailable if the server goes away or is too busy;
//  - kConflict if the server is a standby, or another transaction is in the way;
//  - kIo if the role lacks a privilege, or the disk is full;
//  - kBadInput if a text is not UTF-8;
//  - kMapDamaged if the tables or their values are not those of a map;
//  - kInternal otherwise.
Error StatementError(const std::string& name, const PGresult* result);

// Returns the error of a connection that could not be made; `message` is libpq's. kIo if the server
// refuses the role, the password or the encryption, kNotFound if it has no such database, else
// kUnavailable.
Error ConnectError(const std::string& name, const std::string& message);

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_POSTGRES_ERRORS_H_
