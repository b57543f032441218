# board_field(<variable> <field>): a field of the board DAVAR_TARGET in boards.json, the only list of
# boards.
file(READ "${CMAKE_CURRENT_LIST_DIR}/../boards.json" boards)
function(board_field variable field)
  string(JSON value ERROR_VARIABLE missing GET "${boards}" "${DAVAR_TARGET}" "${field}")
  if(missing)
    message(FATAL_ERROR "DAVAR_TARGET: a board of port/bare_metal/boards.json with a ${field}, found '${DAVAR_TARGET}'")
  endif()
  set(${variable} "${value}" PARENT_SCOPE)
endfunction()
