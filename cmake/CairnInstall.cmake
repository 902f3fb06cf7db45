# `cmake --install`, find_package(cairn) and the Debian package.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(cairn_config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/cairn)

# The libraries, as cairn::core, cairn::engine, ... Neither the verbs of the shell
# nor the laboratory are a library for others.
# What a device needs to track and to ask a server is a component of its own, `fusion`; what servers
# are built from, `development`, stands on it.
get_property(cairn_libraries GLOBAL PROPERTY CAIRN_LIBRARIES)
list(FILTER cairn_libraries EXCLUDE REGEX "^cairn_(cli|lab)(_|$)")
set(cairn_fusion_libraries ${cairn_libraries})
list(FILTER cairn_fusion_libraries INCLUDE REGEX "^cairn_(core|fusion|wire)(_|$)")
# Photos, scenes and adjustments are for servers: a device gets the images of its camera decoded.
list(FILTER cairn_fusion_libraries EXCLUDE REGEX "^cairn_core_(adjust|images|features_sift|scene)$")
set(cairn_server_libraries ${cairn_libraries})
list(REMOVE_ITEM cairn_server_libraries ${cairn_fusion_libraries})
cairn_require_built(runtime cairn cairn_sqlite)
cairn_require_built(lab cairn-lab)
cairn_require_built(fusion ${cairn_fusion_libraries})
cairn_require_built(development ${cairn_server_libraries})
add_dependencies(cairn cairn_sqlite)  # So that who builds `cairn` can install it.

install(TARGETS ${cairn_fusion_libraries} EXPORT cairnFusionTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/cairn COMPONENT fusion)
install(EXPORT cairnFusionTargets NAMESPACE cairn:: DESTINATION ${cairn_config_dir}
  COMPONENT fusion)
install(TARGETS ${cairn_server_libraries} EXPORT cairnTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/cairn COMPONENT development)
install(EXPORT cairnTargets NAMESPACE cairn:: DESTINATION ${cairn_config_dir}
  COMPONENT development)

# Headers lie in one folder per room below cairn/, and include each other so.
function(cairn_install_headers component)
  list(JOIN ARGN "," rooms)
  set(stage ${PROJECT_BINARY_DIR}/installed_headers/${component})
  install(CODE "execute_process(COMMAND \"${CMAKE_COMMAND}\"
    \"-DSOURCE_DIR=${PROJECT_SOURCE_DIR}\" \"-DSTAGE_DIR=${stage}\" \"-DROOMS=${rooms}\"
    -P \"${PROJECT_SOURCE_DIR}/cmake/StageHeaders.cmake\" COMMAND_ERROR_IS_FATAL ANY)"
    COMPONENT ${component})
  install(DIRECTORY ${stage}/cairn DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT ${component})
endfunction()
cairn_install_headers(fusion core fusion)
cairn_install_headers(development storage engine ingest http eval mapping)

# pkg-config, for projects without CMake. The archives are static, so Libs has all that they need.
function(cairn_pkg_config file component)
  # The archives refer to each other, and pkg-config keeps no groups of libraries. A linker script is
  # such a group. It has no name of an archive, which lintian would unpack.
  set(archives ${PC_TARGETS})
  list(TRANSFORM archives PREPEND "lib")
  list(TRANSFORM archives APPEND ".a")
  list(JOIN archives " " archives)
  set(PC_ARCHIVES ${file}.ld)
  file(WRITE ${PROJECT_BINARY_DIR}/${PC_ARCHIVES} "GROUP ( ${archives} )\n")
  install(FILES ${PROJECT_BINARY_DIR}/${PC_ARCHIVES} DESTINATION ${CMAKE_INSTALL_LIBDIR}/cairn
    COMPONENT ${component})
  # From the folder of the file, so that the prefix may be any.
  file(RELATIVE_PATH PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/cairn.pc.in ${PROJECT_BINARY_DIR}/${file}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${file}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
    COMPONENT ${component})
endfunction()
set(PC_NAME "Cairn fusion")
set(PC_DESCRIPTION "Tracks a device and asks a Cairn server where it is")
set(PC_TARGETS ${cairn_fusion_libraries})
list(FILTER PC_TARGETS EXCLUDE REGEX "klt$")  # That needs OpenCV.
set(PC_REQUIRES "eigen3 fmt spdlog geographiclib nlohmann_json cpp-httplib openssl")
set(PC_CFLAGS "")
set(PC_SYSTEM_LIBS "-lpthread -lstdc++ -lm")
cairn_pkg_config(cairn-fusion fusion)
set(PC_NAME "Cairn")
set(PC_DESCRIPTION "Maps of places, and the camera poses of photos in them")
set(PC_TARGETS ${cairn_server_libraries})
set(PC_REQUIRES "cairn-fusion sqlite3 libzstd libxxhash libjpeg libpng zlib")
if(CAIRN_WITH_POSTGRES)
  string(APPEND PC_REQUIRES " libpq")
endif()
set(PC_CFLAGS "-I${OpenCV_INCLUDE_DIR}")
set(PC_SYSTEM_LIBS "-lceres -lglog -lgflags -lspqr -lcholmod -lcxsparse -lfaiss -lopenblas -lgomp \
-lopencv_calib3d -lopencv_video -lopencv_imgproc -lopencv_core -lstdc++ -lm")
cairn_pkg_config(cairn development)

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/cairnConfig.cmake.in ${PROJECT_BINARY_DIR}/cairnConfig.cmake
  INSTALL_DESTINATION ${cairn_config_dir})
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/cairnConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/cairnConfig.cmake ${PROJECT_BINARY_DIR}/cairnConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/FindOpenCV.cmake
  DESTINATION ${cairn_config_dir} COMPONENT fusion)

# The program with its manual, the extension that lets the sqlite3 shell look into maps, and the unit
# of the server.
install(TARGETS cairn RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
install(TARGETS cairn_sqlite LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/cairn COMPONENT runtime)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/cairn COMPONENT runtime)
install(FILES ${PROJECT_SOURCE_DIR}/deploy/systemd/cairn@.service
  DESTINATION lib/systemd/system COMPONENT runtime)
install(TARGETS cairn-lab RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT lab)
foreach(program_component cairn:runtime cairn-lab:lab)
  string(REPLACE ":" ";" program_component ${program_component})
  list(GET program_component 0 program)
  list(GET program_component 1 component)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/manual/${program}/man1
    DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT ${component})
  install(DIRECTORY ${PROJECT_BINARY_DIR}/manual/${program}/completions
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion COMPONENT ${component})
endforeach()

include(CairnPackages)
