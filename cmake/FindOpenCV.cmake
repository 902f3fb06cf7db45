# Debian ships OpenCV's own CMake configuration only with libopencv-dev, which pulls in every module,
# VTK and Qt. This finds the modules asked for in COMPONENTS and defines targets with the names
# OpenCV itself uses: opencv_core, opencv_imgproc, ...
find_path(OpenCV_INCLUDE_DIR opencv2/core/version.hpp PATH_SUFFIXES opencv4)
set(OpenCV_VERSION)
if(OpenCV_INCLUDE_DIR)
  file(READ ${OpenCV_INCLUDE_DIR}/opencv2/core/version.hpp opencv_version_header)
  foreach(part MAJOR MINOR REVISION)
    string(REGEX MATCH "CV_VERSION_${part} +([0-9]+)" _ "${opencv_version_header}")
    list(APPEND OpenCV_VERSION ${CMAKE_MATCH_1})
  endforeach()
  list(JOIN OpenCV_VERSION "." OpenCV_VERSION)
endif()

set(OpenCV_LIBS)
foreach(module ${OpenCV_FIND_COMPONENTS})
  find_library(OpenCV_${module}_LIBRARY opencv_${module})
  mark_as_advanced(OpenCV_${module}_LIBRARY)
  if(OpenCV_${module}_LIBRARY)
    set(OpenCV_${module}_FOUND TRUE)
    list(APPEND OpenCV_LIBS opencv_${module})
    if(NOT TARGET opencv_${module})
      add_library(opencv_${module} SHARED IMPORTED)
      set_target_properties(opencv_${module} PROPERTIES
        IMPORTED_LOCATION ${OpenCV_${module}_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${OpenCV_INCLUDE_DIR})
    endif()
  endif()
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCV REQUIRED_VARS OpenCV_INCLUDE_DIR OpenCV_LIBS
  VERSION_VAR OpenCV_VERSION HANDLE_COMPONENTS)
