# "#V by 3" is a shape; Doxygen takes it for a link unless the # is escaped. Nothing else looks like this in our text.
s/#([A-Z]|bins|slabs)\b/\\#\1/g
