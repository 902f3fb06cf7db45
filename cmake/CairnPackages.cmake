# Debian packages: cpack --config build/release/CPackConfig.cmake makes cairn_*.deb (the program and
# its server), libcairn-dev_*.deb, libcairn-fusion-dev_*.deb and cairn-lab_*.deb.
# With pybind11 also python3-cairn_*.deb.
set(CPACK_PACKAGE_NAME cairn)
set(CPACK_PACKAGE_VENDOR "The Cairn authors")
set(CPACK_PACKAGE_CONTACT "The Cairn authors <cairn@packages.debian.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime development fusion lab)
if(CAIRN_WITH_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# cairn_package(component name section DESCRIPTION "..." ...): what all packages have.
function(cairn_package component package section summary description)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${summary}\n${description}" PARENT_SCOPE)
  set(doc ${PROJECT_BINARY_DIR}/debian/${package})
  file(MAKE_DIRECTORY ${doc})
  if(GZIP_PROGRAM)
    execute_process(COMMAND ${GZIP_PROGRAM} -9 -n -c ${PROJECT_SOURCE_DIR}/deploy/debian/changelog
      OUTPUT_FILE ${doc}/changelog.gz)
    install(FILES ${doc}/changelog.gz DESTINATION share/doc/${package} COMPONENT ${component})
  endif()
  install(FILES ${PROJECT_SOURCE_DIR}/deploy/debian/copyright DESTINATION share/doc/${package}
    COMPONENT ${component})
endfunction()
cairn_package(runtime cairn science "Visual positioning: where a photo was taken"
  "A server that answers a photo, a rough position and the direction of gravity\nwith the pose of the camera on Earth, and the program that makes its maps from\nordinary photos. A map is one SQLite file or a PostgreSQL database.")
cairn_package(development libcairn-dev libdevel "Visual positioning: library of servers"
  "Static libraries and headers to localize photos in maps of Cairn, and to make\nsuch maps, from a program of one's own.")
cairn_package(fusion libcairn-fusion-dev libdevel "Visual positioning: library of devices"
  "Static libraries and headers that track a device by its camera and inertial\nsensors and ask a Cairn server where it is.")
cairn_package(lab cairn-lab science "Visual positioning: simulated cities and experiments"
  "Simulates cities with ground truth, repeats the experiments of Cairn's paper,\nand measures the speed of the engine.")

set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA
  "${PROJECT_SOURCE_DIR}/deploy/debian/postinst;${PROJECT_SOURCE_DIR}/deploy/debian/postrm")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LAB_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "adduser, proj-data")  # The latter has the geoid.
set(CPACK_DEBIAN_LAB_PACKAGE_DEPENDS "proj-data")
set(CPACK_DEBIAN_LAB_PACKAGE_SUGGESTS "gnuplot-nox")
# Static libraries have no shared dependencies to compute; their users link these.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libcairn-fusion-dev (= ${PROJECT_VERSION}), libsqlite3-dev, nlohmann-json3-dev, libzstd-dev, \
libxxhash-dev, libcpp-httplib-dev, libjpeg62-turbo-dev, libpng-dev, libceres-dev, libfaiss-dev, \
libopenblas-dev, libopencv-core-dev, libopencv-imgproc-dev, libopencv-calib3d-dev, \
libopencv-video-dev")
if(CAIRN_WITH_POSTGRES)
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libpq-dev")
endif()
set(CPACK_DEBIAN_FUSION_PACKAGE_DEPENDS
  "libeigen3-dev, libfmt-dev, libspdlog-dev, libgeographiclib-dev, proj-data, nlohmann-json3-dev, \
libcpp-httplib-dev, libssl-dev")
# For cairn::core_features_klt.
set(CPACK_DEBIAN_FUSION_PACKAGE_RECOMMENDS
  "libopencv-core-dev, libopencv-imgproc-dev, libopencv-video-dev")
if(CAIRN_WITH_PYTHON)
  cairn_package(python python3-cairn python "Visual positioning: Python module"
    "Opens maps of Cairn, localizes photos in them, makes maps, and asks servers, with\nnumpy arrays in and out.")
  # The module fits one minor version of Python, the one it is built for.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  math(EXPR cairn_next_python "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${cairn_next_python}), python3-numpy, \
proj-data")
endif()
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_STRIP_FILES ON)
include(CPack)
