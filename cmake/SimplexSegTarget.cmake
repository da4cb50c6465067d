# Compiler and linker options of all targets.
add_library(simplexseg_options INTERFACE)
target_include_directories(simplexseg_options INTERFACE ${CMAKE_SOURCE_DIR}/src ${SIMPLEXSEG_GENERATED})
target_compile_options(simplexseg_options INTERFACE
  "$<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;$<$<BOOL:${SIMPLEXSEG_WARNINGS_AS_ERRORS}>:-Werror>;-fno-math-errno;-fno-trapping-math>"
  $<$<AND:$<COMPILE_LANGUAGE:CUDA>,$<BOOL:${SIMPLEXSEG_WARNINGS_AS_ERRORS}>>:-Werror=all-warnings>)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND SIMPLEXSEG_ARCH)
  target_compile_options(simplexseg_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-march=${SIMPLEXSEG_ARCH}>)
  # The alignment of Eigen depends on the instruction set, so host code in .cu files must use the same one.
  target_compile_options(simplexseg_options INTERFACE $<$<COMPILE_LANGUAGE:CUDA>:-Xcompiler=-march=${SIMPLEXSEG_ARCH}>)
endif()
if(SIMPLEXSEG_REPRODUCIBLE)   # the last map that fits is used
  target_compile_options(simplexseg_options INTERFACE
    "$<$<COMPILE_LANGUAGE:CXX>:-ffile-prefix-map=${CMAKE_SOURCE_DIR}=.;-ffile-prefix-map=${CMAKE_BINARY_DIR}=build>")
endif()
if(SIMPLEXSEG_ASSERTIONS)
  target_compile_definitions(simplexseg_options INTERFACE SIMPLEXSEG_ASSERTIONS)
endif()
if(SIMPLEXSEG_SANITIZE)
  # GCC warns falsely of uninitialised variables in code with checks (its manual, -fsanitize), also in <regex>.
  target_compile_options(simplexseg_options INTERFACE
    $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-maybe-uninitialized>
    $<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${SIMPLEXSEG_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer>)
  if(SIMPLEXSEG_SANITIZE MATCHES undefined AND NOT SIMPLEXSEG_FUZZ)
    # These checks accompany every use of a reference and cost a third of the compile time. The address sanitizer finds what matters of
    # them: accesses through null and dangling pointers.
    target_compile_options(simplexseg_options INTERFACE
      $<$<COMPILE_LANGUAGE:CXX>:-fno-sanitize=null,alignment,object-size,vptr,nonnull-attribute,returns-nonnull-attribute>)
  endif()
  target_link_options(simplexseg_options INTERFACE -fsanitize=${SIMPLEXSEG_SANITIZE})
endif()

if(SIMPLEXSEG_COVERAGE)
  target_link_options(simplexseg_options INTERFACE --coverage)
endif()

if(SIMPLEXSEG_FUZZ)   # coverage instrumentation for libFuzzer
  target_compile_options(simplexseg_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Precompiled headers: the standard library and Eigen for all modules (simplexseg_headers), plus Qt for the window and GoogleTest
# for the tests. They contain no headers of the project, so a change to one recompiles only its users.
set(SIMPLEXSEG_PRECOMPILED_STANDARD <algorithm> <array> <atomic> <bit> <charconv> <chrono> <cmath> <cstddef> <cstdint> <cstdio>
  <cstdlib> <cstring> <filesystem> <fstream> <functional> <iterator> <limits> <map> <memory> <mutex> <numbers> <numeric> <optional>
  <random> <set> <span> <sstream> <stdexcept> <string> <string_view> <thread> <tuple> <type_traits> <utility> <vector>
  <Eigen/Geometry>)
set(SIMPLEXSEG_PRECOMPILED_QT <QAction> <QApplication> <QBoxLayout> <QCheckBox> <QComboBox> <QDialog> <QDialogButtonBox> <QDir> <QElapsedTimer>
  <QEvent> <QFileDialog> <QFileInfo> <QGridLayout> <QHeaderView> <QImage> <QKeyEvent> <QLabel> <QLineEdit> <QLocale> <QMainWindow>
  <QMenu> <QMessageBox> <QMouseEvent> <QOpenGLWidget> <QPainter> <QPushButton> <QScrollArea> <QSettings> <QSlider> <QSpinBox>
  <QSplitter> <QString> <QStyle> <QTimer> <QToolButton> <QTreeWidget> <QWheelEvent> <QWidget>)

# simplexseg_precompile(TARGET HEADERS...): precompiles these headers for a target.
function(simplexseg_precompile target)
  if(NOT SIMPLEXSEG_PRECOMPILED_HEADERS)
    return()
  endif()
  target_precompile_headers(${target} PRIVATE ${ARGN})
  simplexseg_precompiled_options(${target})
endfunction()

# simplexseg_share_precompiled(TARGET OWNER): uses the precompiled headers of OWNER, which is compiled with the same options.
function(simplexseg_share_precompiled target owner)
  if(SIMPLEXSEG_PRECOMPILED_HEADERS)
    target_precompile_headers(${target} REUSE_FROM ${owner})
    simplexseg_precompiled_options(${target})
  endif()
endfunction()
function(simplexseg_precompiled_options target)   # required by ccache with GCC
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fpch-preprocess>)
endfunction()

# simplexseg_headers_owner(NAME LIBRARIES...): an empty program that owns the precompiled headers of other programs.
function(simplexseg_headers_owner name)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/precompiled.cpp CONTENT "int main() {}\n")
  add_executable(${name} ${CMAKE_BINARY_DIR}/generated/precompiled.cpp)
  target_link_libraries(${name} PRIVATE ${ARGN} simplexseg_options)
endfunction()

# simplexseg_kernel_sources(FOLDER): compile options of the two sources in src/gpu with the CPU kernels. Without contraction
# of floating-point operations, scalar and eightfold vectorised kernels have identical results. On x86-64 the second source
# always uses AVX2; the program checks the CPU before it calls it (docs/adr/0025-eight-vertices-at-once.md).
function(simplexseg_kernel_sources folder)
  set(options -ffp-contract=off)
  set_source_files_properties(${folder}/cpu_engine.cpp PROPERTIES COMPILE_OPTIONS "${options}" SKIP_PRECOMPILE_HEADERS ON
    SKIP_UNITY_BUILD_INCLUSION ON)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    list(APPEND options -march=x86-64-v3)
  endif()
  # The address sanitizer makes the second source ten times slower to compile; its kernels are those of the first one.
  if(SIMPLEXSEG_SANITIZE MATCHES address)
    list(APPEND options -fno-sanitize=all -DSIMPLEXSEG_FEW_FORCE_SETS)
  endif()
  set_source_files_properties(${folder}/eight_vertices.cpp PROPERTIES COMPILE_OPTIONS "${options}" SKIP_PRECOMPILE_HEADERS ON
    SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# simplexseg_module_options(TARGET [BIT_EXACT]): options of every module. BIT_EXACT: no unity builds, except with sanitizers or
# SIMPLEXSEG_BATCHES_EVERYWHERE, because the optimiser contracts a*b + c across the functions of a batch and changes last bits.
function(simplexseg_module_options target)
  cmake_parse_arguments(ARG "BIT_EXACT" "" "" ${ARGN})
  target_link_libraries(${target} PRIVATE simplexseg_options)
  set(covered OFF)
  if(SIMPLEXSEG_COVERAGE AND target MATCHES "^simplexseg_(io|remote|archive|serve|field)$")   # the others are those of the preset release
    set(covered ON)
    target_compile_options(${target} PRIVATE -O1 --coverage)
    target_compile_definitions(${target} PRIVATE SIMPLEXSEG_COVERAGE)
  else()
    simplexseg_share_precompiled(${target} simplexseg_headers)
  endif()
  if(SIMPLEXSEG_BATCHES AND (SIMPLEXSEG_SANITIZE OR SIMPLEXSEG_BATCHES_EVERYWHERE OR covered OR NOT ARG_BIT_EXACT))
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  endif()
endfunction()

set(SIMPLEXSEG_BUILT_IN "" CACHE PATH "Build folder whose libraries of the modules below forces are linked, not compiled again")
# simplexseg_module(NAME LIBRARIES...): library of all sources in src/NAME; LIBRARIES: modules that it uses.
function(simplexseg_module name)
  cmake_parse_arguments(ARG "BIT_EXACT" "" "" ${ARGN})
  set(library ${SIMPLEXSEG_BUILT_IN}/src/${name}/libsimplexseg_${name}.a)
  if(SIMPLEXSEG_BUILT_IN AND EXISTS ${library} AND name MATCHES "^(core|mesh|image|field|model)$")
    add_library(simplexseg_${name} STATIC IMPORTED GLOBAL)
    set_target_properties(simplexseg_${name} PROPERTIES IMPORTED_LOCATION ${library})
    target_link_libraries(simplexseg_${name} INTERFACE ${ARG_UNPARSED_ARGUMENTS})
    return()
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_library(simplexseg_${name} STATIC ${sources})
  target_link_libraries(simplexseg_${name} PUBLIC ${ARG_UNPARSED_ARGUMENTS})
  if(ARG_BIT_EXACT)
    simplexseg_module_options(simplexseg_${name} BIT_EXACT)
  else()
    simplexseg_module_options(simplexseg_${name})
  endif()
endfunction()

# Mesa's software renderer compiles its shaders for each window; without optimisation a test of the window takes a fifth less time.
set(SIMPLEXSEG_FAST_SHADERS GALLIVM_PERF=nopt)
# A display has one keyboard: tests that need it have a display of their own, or run serially where xvfb-run is missing.
find_program(SIMPLEXSEG_XVFB_RUN xvfb-run)
mark_as_advanced(SIMPLEXSEG_XVFB_RUN)
if(SIMPLEXSEG_XVFB_RUN)
  set(SIMPLEXSEG_OWN_DISPLAY env QT_QPA_PLATFORM=xcb ${SIMPLEXSEG_FAST_SHADERS} ${SIMPLEXSEG_XVFB_RUN} -a -s "-screen 0 1920x1080x24 -noreset")
  set(SIMPLEXSEG_SERIAL OFF)
else()
  set(SIMPLEXSEG_OWN_DISPLAY)
  set(SIMPLEXSEG_SERIAL ON)
endif()

# simplexseg_tests(NAME SOURCES... LIBRARIES... [KEYBOARD FILTER] [SHARDS N]): a GoogleTest program. ctest has two sets of tests: each
# case separately (label case), for developers, and N shards of all cases (ctest -C Shards; label shard; default 2), which
# scripts/test runs: most cases take less time than the start of a process. Tests are compiled at -O1, since they need little
# time themselves. OWN_HEADERS: does not use the shared precompiled headers. Cases of FILTER (syntax of --gtest_filter) need
# the keyboard of their display.
function(simplexseg_tests name)
  cmake_parse_arguments(ARG "OWN_HEADERS" "KEYBOARD;SHARDS" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES} ${CMAKE_SOURCE_DIR}/tests/locale/set_locale.cpp)
  if(SIMPLEXSEG_BATCHES)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 16)
  endif()
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} simplexseg_options GTest::gtest_main)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(NOT ARG_OWN_HEADERS)
    simplexseg_share_precompiled(${name} simplexseg_test_headers)
  endif()
  include(GoogleTest)
  set(cases DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600 LABELS ${name}_case)
  if(NOT ARG_SHARDS)
    set(ARG_SHARDS 2)
  endif()
  math(EXPR last "${ARG_SHARDS} - 1")
  if(ARG_KEYBOARD)
    set(others TEST_FILTER -${ARG_KEYBOARD})
    gtest_discover_tests(${name} TEST_LIST ${name}_KEYBOARD TEST_FILTER ${ARG_KEYBOARD} ${cases} RUN_SERIAL ON)
    foreach(k RANGE ${last})
      simplexseg_shard(${name} keyboard_shard_${k} ${k} ${ARG_SHARDS} ${SIMPLEXSEG_OWN_DISPLAY} $<TARGET_FILE:${name}> --gtest_filter=${ARG_KEYBOARD})
      set_tests_properties(${name}_keyboard_shard_${k} PROPERTIES RUN_SERIAL ${SIMPLEXSEG_SERIAL} COST 200)
    endforeach()
    set(but --gtest_filter=-${ARG_KEYBOARD})
  endif()
  gtest_discover_tests(${name} ${others} ${cases})
  foreach(k RANGE ${last})
    simplexseg_shard(${name} shard_${k} ${k} ${ARG_SHARDS} $<TARGET_FILE:${name}> ${but})
  endforeach()
endfunction()

# simplexseg_shard(PROGRAM NAME INDEX COUNT COMMAND...): adds part INDEX of COUNT of the cases of a program, which COMMAND starts, as
# the test PROGRAM_NAME, which writes its results to results/PROGRAM_NAME.xml.
function(simplexseg_shard program name index count)
  set(test ${program}_${name})
  add_test(NAME ${test} CONFIGURATIONS Shards COMMAND ${ARGN} --gtest_brief=1 --gtest_output=xml:${CMAKE_BINARY_DIR}/results/${test}.xml)
  set_tests_properties(${test} PROPERTIES TIMEOUT 1800 LABELS "${program};shard"
    ENVIRONMENT "GTEST_SHARD_INDEX=${index};GTEST_TOTAL_SHARDS=${count};${SIMPLEXSEG_FAST_SHADERS}")
endfunction()
