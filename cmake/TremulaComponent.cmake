# tremula_component(NAME [INTERNAL] [SOURCES patterns...] [DEPENDS components...] [PUBLIC libs...] [PRIVATE libs...] [DEFINITIONS ...])
# One library per folder of src/tremula, from every .cpp in it, or from those that SOURCES says. It sees the headers of its own folder and of those that it
# names, and no others: an include against the arrows of the cascade does not build (tests/CMakeLists.txt: arrows). What is no component
# and links one sees them all.
function(tremula_component name)
  cmake_parse_arguments(ARG "INTERNAL" "" "SOURCES;DEPENDS;PUBLIC;PRIVATE;DEFINITIONS" ${ARGN})
  if(NOT ARG_SOURCES)
    set(ARG_SOURCES *.cpp)
  endif()
  list(TRANSFORM ARG_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  file(GLOB sources CONFIGURE_DEPENDS ${ARG_SOURCES})
  set(target tremula_${name})
  if(sources)
    set(scope PUBLIC)
    add_library(${target} ${sources})  # static, or shared with BUILD_SHARED_LIBS
    tremula_compile_options(${target})
    tremula_library_properties(${target})
  else()
    set(scope INTERFACE)
    add_library(${target} INTERFACE)
  endif()
  add_library(tremula::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} TREMULA_COMPONENT TRUE)
  set(all_headers $<$<NOT:$<BOOL:$<TARGET_PROPERTY:TREMULA_COMPONENT>>>:${PROJECT_SOURCE_DIR}/src>)
  target_include_directories(${target} ${scope} $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_include_directories(${target} INTERFACE $<BUILD_INTERFACE:${all_headers}>)
  # A folder that holds nothing but tremula/NAME, for each that may be seen.
  set(views ${PROJECT_BINARY_DIR}/include)
  file(MAKE_DIRECTORY ${views}/${name}/tremula)
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${views}/${name}/tremula/${name} SYMBOLIC)
  if(sources)
    foreach(seen ${name} ${ARG_DEPENDS})
      target_include_directories(${target} PRIVATE $<BUILD_INTERFACE:${views}/${seen}>)
    endforeach()
  endif()
  target_compile_features(${target} ${scope} cxx_std_20)
  target_compile_definitions(${target} ${scope} ${ARG_DEFINITIONS})
  list(TRANSFORM ARG_DEPENDS PREPEND tremula::)
  target_link_libraries(${target} ${scope} ${ARG_DEPENDS} ${ARG_PUBLIC})
  if(sources)
    target_link_libraries(${target} PRIVATE ${ARG_PRIVATE})
  endif()
  if(NOT ARG_INTERNAL)  # what is installed
    set_property(GLOBAL APPEND PROPERTY TREMULA_COMPONENTS ${target})
  endif()
endfunction()

# How a library is built and named: tremula_${name}, with the versions of the project that fit each other in its soname.
function(tremula_library_properties target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON VERSION ${PROJECT_VERSION}
                        SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} INSTALL_RPATH "$ORIGIN")
endfunction()

function(tremula_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor)
  if(TREMULA_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
    # Copies of short vectors, of which GCC 13 and later say at times that they reach beyond their end, and members
    # that are destroyed where a constructor throws, of which they say that none were made.
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
      target_compile_options(${target} PRIVATE -Wno-error=array-bounds -Wno-error=stringop-overflow
                             -Wno-error=maybe-uninitialized)
    endif()
  endif()
  # Same bytes whatever the machine: no contraction of a*b+c into fma behind our back.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  # Nobody reads errno after sqrt nor the exception flags; with them, loops with roots and comparisons would not
  # become vector code.
  target_compile_options(${target} PRIVATE -fno-math-errno -fno-trapping-math)
endfunction()

if(TREMULA_SANITIZE)
  add_compile_options(-fsanitize=${TREMULA_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${TREMULA_SANITIZE})
  if(TREMULA_SANITIZE STREQUAL "thread")
    include_directories(BEFORE ${PROJECT_SOURCE_DIR}/tests/tsan)  # loops on threads that it sees
  endif()
endif()
if(TREMULA_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()
