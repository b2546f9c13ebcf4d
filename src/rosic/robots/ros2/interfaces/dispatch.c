// Finds a type support inside the very library that asks.
//
// What ROS 2 links in its place looks for one more library per type support, by name, on the
// library path. Here there is one library for all, and it lies in a folder that nobody named.

#define _GNU_SOURCE
#include <dlfcn.h>
#include <stddef.h>
#include <string.h>

#include "rosidl_runtime_c/message_type_support_struct.h"
#include "rosidl_runtime_c/service_type_support_struct.h"
#include "rosidl_typesupport_c/type_support_map.h"

static void * find_here(const char * symbol)
{
  static void * here = NULL;
  Dl_info self;
  if (here == NULL && dladdr((void *)find_here, &self) != 0) {
    here = dlopen(self.dli_fname, RTLD_LAZY | RTLD_NOLOAD);
  }
  return here == NULL ? NULL : dlsym(here, symbol);
}

static const void * find(const char * own, const void * handle, const void * data, const char * wanted)
{
  const type_support_map_t * map = data;
  if (strcmp(own, wanted) == 0) {
    return handle;
  }
  for (size_t i = 0; i < map->size; ++i) {
    if (strcmp(map->typesupport_identifier[i], wanted) == 0) {
      const void * (*get)(void) = (const void * (*)(void))find_here(map->symbol_name[i]);
      return get == NULL ? NULL : get();
    }
  }
  return NULL;
}

const rosidl_message_type_support_t * rosic_find_message(
  const rosidl_message_type_support_t * handle, const char * wanted)
{
  return find(handle->typesupport_identifier, handle, handle->data, wanted);
}

const rosidl_service_type_support_t * rosic_find_service(
  const rosidl_service_type_support_t * handle, const char * wanted)
{
  return find(handle->typesupport_identifier, handle, handle->data, wanted);
}
