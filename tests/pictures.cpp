// The reader of pictures.hpp, apart from what warnings are taken for errors in: it is not ours.
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#include <stb_image.h>
