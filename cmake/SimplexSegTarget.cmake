# What every target of the project is compiled with.
add_library(simplexseg_options INTERFACE)
target_include_directories(simplexseg_options INTERFACE ${CMAKE_SOURCE_DIR}/src ${SIMPLEXSEG_GENERATED})
target_compile_options(simplexseg_options INTERFACE
  "$<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;$<$<BOOL:${SIMPLEXSEG_WARNINGS_AS_ERRORS}>:-Werror>;-fno-math-errno;-fno-trapping-math>"
  $<$<AND:$<COMPILE_LANGUAGE:CUDA>,$<BOOL:${SIMPLEXSEG_WARNINGS_AS_ERRORS}>>:-Werror=all-warnings>)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND SIMPLEXSEG_ARCH)
  target_compile_options(simplexseg_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-march=${SIMPLEXSEG_ARCH}>)
  # Eigen's alignment follows the instruction set: host code of .cu files must agree.
  target_compile_options(simplexseg_options INTERFACE $<$<COMPILE_LANGUAGE:CUDA>:-Xcompiler=-march=${SIMPLEXSEG_ARCH}>)
endif()
if(SIMPLEXSEG_ASSERTIONS)
  target_compile_definitions(simplexseg_options INTERFACE SIMPLEXSEG_ASSERTIONS)
endif()
if(SIMPLEXSEG_SANITIZE)
  target_compile_options(simplexseg_options INTERFACE
    $<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${SIMPLEXSEG_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer>)
  target_link_options(simplexseg_options INTERFACE -fsanitize=${SIMPLEXSEG_SANITIZE})
endif()

if(SIMPLEXSEG_FUZZ)   # the coverage that libFuzzer goes by
  target_compile_options(simplexseg_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# simplexseg_kernel_sources(FOLDER): how the two units of src/gpu with the CPU's kernels are compiled by targets of this
# directory. One after another and eight at once vertices have the same bits: nothing is contracted. On x86-64 the second
# unit has AVX2 always; the program asks the machine before it goes there (docs/adr/0025-eight-vertices-at-once.md).
function(simplexseg_kernel_sources folder)
  set(options -ffp-contract=off)
  set_source_files_properties(${folder}/cpu_engine.cpp PROPERTIES COMPILE_OPTIONS "${options}")
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    list(APPEND options -march=x86-64-v3)
  endif()
  set_source_files_properties(${folder}/eight_vertices.cpp PROPERTIES COMPILE_OPTIONS "${options}")
endfunction()

# simplexseg_room(NAME LIBRARIES...): the library of src/NAME, made of all its sources; the rooms it stands on.
function(simplexseg_room name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_library(simplexseg_${name} STATIC ${sources})
  target_link_libraries(simplexseg_${name} PUBLIC ${ARGN} PRIVATE simplexseg_options)
endfunction()

# simplexseg_tests(NAME SOURCES... LIBRARIES... [ALONE FILTER]): a GoogleTest program whose cases ctest knows one by one, with
# the label NAME. No other test runs beside those of FILTER (as --gtest_filter has it).
function(simplexseg_tests name)
  cmake_parse_arguments(ARG "" "ALONE" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} simplexseg_options GTest::gtest_main)
  include(GoogleTest)
  if(ARG_ALONE)
    set(others TEST_FILTER -${ARG_ALONE})
    gtest_discover_tests(${name} TEST_LIST ${name}_ALONE TEST_FILTER ${ARG_ALONE} DISCOVERY_MODE PRE_TEST
      DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600 LABELS ${name} RUN_SERIAL ON)
  endif()
  gtest_discover_tests(${name} ${others} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600 LABELS ${name})
endfunction()
