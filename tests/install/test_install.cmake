# Installs the build into a fresh prefix and builds and runs another project against it, which must say the same however
# it is compiled: plainly, for wider vector units than the library, and under ASan, which the library may be without.
# Wants BUILD (the build folder), CONSUMER (the other project), WORK (a folder of this test's own), GENERATOR, COMPILER,
# and FLAGS, without which nothing can be linked to this build.
file(REMOVE_RECURSE ${WORK})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN} failed: ${result}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)

set(configure ${CMAKE_COMMAND} -S ${CONSUMER} -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
    -DCMAKE_PREFIX_PATH=${WORK}/prefix)
function(build name flags)
  run(${configure} -B ${WORK}/${name} -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS=${FLAGS} ${flags}" ${ARGN})
  run(${CMAKE_COMMAND} --build ${WORK}/${name})
endfunction()
function(says_as_the_first name)
  run(${WORK}/${name}/consumer)
  if(NOT output MATCHES "first frequency [0-9.]+ Hz, 60 samples\nthe top is 0[.][0-9]+ m away, 1[.]000000 of it the end's; trace 6[.]000000")
    message(FATAL_ERROR "the consumer '${name}' said: ${output}")
  endif()
  if(DEFINED first AND NOT output STREQUAL first)
    message(FATAL_ERROR "the consumer '${name}' said:\n${output}and the first:\n${first}")
  endif()
  set(first "${output}" PARENT_SCOPE)
endfunction()

build(plain "" -DCOMPONENTS=geometry,modes,tremula)
says_as_the_first(plain)
# `native` is what a user writes; that this machine has AVX is asked first, so that the test says what it tested.
foreach(flags -march=native -mavx2 "-mavx512f -mfma")
  string(REGEX REPLACE "-m(arch=)?([a-z0-9]+).*" "\\2" unit ${flags})
  build(wide-${unit} ${flags})
  file(STRINGS /proc/cpuinfo has LIMIT_COUNT 1 REGEX "^(flags|Features).* ${unit}( |$)")
  if(unit STREQUAL native OR has)
    says_as_the_first(wide-${unit})
  else()
    message(STATUS "compiled with ${flags} but not run: this machine has no ${unit}")
  endif()
endforeach()
if(FLAGS STREQUAL "")
  build(asan "-march=native -fsanitize=address,undefined -fno-sanitize-recover=all")
  says_as_the_first(asan)
endif()

# What is not there is refused by name.
execute_process(COMMAND ${configure} -B ${WORK}/unknown -DCOMPONENTS=modes,leaves RESULT_VARIABLE result
                OUTPUT_VARIABLE output ERROR_VARIABLE output)
string(REGEX REPLACE "[ \n]+" " " output "${output}")
if(result EQUAL 0 OR NOT output MATCHES "tremula has no component 'leaves'; it has base, numerics,")
  message(FATAL_ERROR "an unknown component was answered: ${output}")
endif()
