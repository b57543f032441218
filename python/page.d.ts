// For tsc. What an element of the page is depends on index.html, so tsc accepts any member of one.
interface EventTarget {
  [member: string]: any;
}
