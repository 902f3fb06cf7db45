// Converts failures of PostgreSQL to cairn::Error.
#ifndef CAIRN_STORAGE_DATABASE_POSTGRES_ERRORS_H_
#define CAIRN_STORAGE_DATABASE_POSTGRES_ERRORS_H_

#include <libpq-fe.h>

#include <string>
#include <string_view>

#include "core/error.h"

namespace cairn::postgres {

// Returns true if the connection cannot be used any more, because the connection or the server has
// ended or is about to (classes 08 and 57P of SQLSTATE, too many connections).
bool EndsConnection(std::string_view sqlstate);

// Returns the error of a failed statement, with PostgreSQL's message and advice:
//  - kUnavailable if the server goes away or is too busy;
//  - kBadInput if the server is a standby, or if a text is not UTF-8;
//  - kConflict if another transaction holds a lock;
//  - kIo if the role lacks a privilege, or the disk is full;
//  - kMapDamaged if the database does not have the tables of a map, or has invalid values;
//  - kInternal otherwise.
Error StatementError(const std::string& name, const PGresult* result);

// Returns the error of a failed connection, whose message from libpq is `message`:
//  - kBadInput if the server is a standby and the caller wants to write;
//  - kIo if the server refuses the address of the client, the password or the encryption;
//  - kNotFound if the server has no such database or role;
//  - kUnavailable otherwise.
Error ConnectError(const std::string& name, const std::string& message);

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_DATABASE_POSTGRES_ERRORS_H_
