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
# Photos and scenes are for servers: a device gets the images of its camera decoded.
list(FILTER cairn_fusion_libraries EXCLUDE REGEX "^cairn_core_(images|features_sift|scene)$")
set(cairn_server_libraries ${cairn_libraries})
list(REMOVE_ITEM cairn_server_libraries ${cairn_fusion_libraries})
install(TARGETS ${cairn_fusion_libraries} EXPORT cairnFusionTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/cairn COMPONENT fusion)
install(EXPORT cairnFusionTargets NAMESPACE cairn:: DESTINATION ${cairn_config_dir}
  COMPONENT fusion)
install(TARGETS ${cairn_server_libraries} EXPORT cairnTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/cairn COMPONENT development)
install(EXPORT cairnTargets NAMESPACE cairn:: DESTINATION ${cairn_config_dir}
  COMPONENT development)

# Headers lie in one folder per room, as the sources include them.
foreach(room core fusion)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${room} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cairn
    COMPONENT fusion FILES_MATCHING PATTERN "*.h")
endforeach()
foreach(room storage engine ingest http eval mapping)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${room} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cairn
    COMPONENT development FILES_MATCHING PATTERN "*.h")
endforeach()

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/cairnConfig.cmake.in ${PROJECT_BINARY_DIR}/cairnConfig.cmake
  INSTALL_DESTINATION ${cairn_config_dir})
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/cairnConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/cairnConfig.cmake ${PROJECT_BINARY_DIR}/cairnConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/FindOpenCV.cmake
  DESTINATION ${cairn_config_dir} COMPONENT fusion)

# The binary, and the extension that lets the sqlite3 shell look into maps.
install(TARGETS cairn RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
install(TARGETS cairn_sqlite LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/cairn COMPONENT runtime)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md
              ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)

# cpack --config build/release/CPackConfig.cmake makes cairn_*.deb, libcairn-dev_*.deb,
# libcairn-fusion-dev_*.deb and python3-cairn_*.deb.
set(CPACK_PACKAGE_NAME cairn)
set(CPACK_PACKAGE_VENDOR "The Cairn authors")
set(CPACK_PACKAGE_CONTACT "The Cairn authors <cairn@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime development fusion)
if(CAIRN_WITH_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME cairn)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libcairn-dev)
set(CPACK_DEBIAN_FUSION_PACKAGE_NAME libcairn-fusion-dev)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION science)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_FUSION_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "proj-data")  # The geoid; OpenCV's GDAL brings it anyway.
# Static libraries have no shared dependencies to compute; their users link these.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libcairn-fusion-dev (= ${PROJECT_VERSION}), libsqlite3-dev, nlohmann-json3-dev, libzstd-dev, \
libxxhash-dev, libcpp-httplib-dev, libjpeg62-turbo-dev, libpng-dev, libceres-dev, libfaiss-dev, \
libopenblas-dev, \
libopencv-core-dev, libopencv-imgproc-dev, libopencv-imgcodecs-dev, libopencv-calib3d-dev, \
libopencv-video-dev")
if(CAIRN_WITH_POSTGRES)
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libpq-dev")
endif()
set(CPACK_DEBIAN_FUSION_PACKAGE_DEPENDS
  "libeigen3-dev, libfmt-dev, libspdlog-dev, libgeographiclib-dev, proj-data")
# For cairn::fusion_transport and cairn::core_features_klt.
set(CPACK_DEBIAN_FUSION_PACKAGE_RECOMMENDS
  "nlohmann-json3-dev, libcpp-httplib-dev, libopencv-core-dev, libopencv-imgproc-dev, \
libopencv-video-dev")
# The module fits one minor version of Python, the one it is built for.
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-cairn)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
math(EXPR cairn_next_python "${Python3_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${cairn_next_python}), python3-numpy, \
proj-data")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_STRIP_FILES ON)
include(CPack)
