// SQLite's API for sources that are compiled twice. In cairn_storage, they call the linked library.
// In the loadable extension (CAIRN_SQLITE_EXTENSION), they call the program that loads the
// extension.
#ifndef CAIRN_STORAGE_INSPECTION_SQLITE_API_H_
#define CAIRN_STORAGE_INSPECTION_SQLITE_API_H_

#ifdef CAIRN_SQLITE_EXTENSION
#include <sqlite3ext.h>
SQLITE_EXTENSION_INIT3
#else
#include <sqlite3.h>
#endif

#endif  // CAIRN_STORAGE_INSPECTION_SQLITE_API_H_
