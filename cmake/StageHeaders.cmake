# Copies the headers of rooms as they are installed: what the sources include as "engine/localizer.h",
# a program outside includes as <cairn/engine/localizer.h>, and so do the installed headers.
# cmake -DSOURCE_DIR=... -DSTAGE_DIR=... -DROOMS=core,fusion -P StageHeaders.cmake
string(REPLACE "," ";" rooms "${ROOMS}")
file(REMOVE_RECURSE ${STAGE_DIR})
# Rooms of other components are included, too.
set(any_room "core|sql|storage|engine|ingest|fusion|http|eval|mapping")
foreach(room ${rooms})
  file(GLOB_RECURSE headers RELATIVE ${SOURCE_DIR} ${SOURCE_DIR}/${room}/*.h)
  foreach(header ${headers})
    file(READ ${SOURCE_DIR}/${header} text)
    string(REGEX REPLACE "#include \"((${any_room})/[^\"]+)\"" "#include <cairn/\\1>" text "${text}")
    file(WRITE ${STAGE_DIR}/cairn/${header} "${text}")
  endforeach()
endforeach()
