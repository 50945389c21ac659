from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Record(_message.Message):
    __slots__ = ("id", "revision", "kind", "title", "state", "content", "wishes", "keep", "is_over", "is_held", "author", "changed_by")
    ID_FIELD_NUMBER: _ClassVar[int]
    REVISION_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    TITLE_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    CONTENT_FIELD_NUMBER: _ClassVar[int]
    WISHES_FIELD_NUMBER: _ClassVar[int]
    KEEP_FIELD_NUMBER: _ClassVar[int]
    IS_OVER_FIELD_NUMBER: _ClassVar[int]
    IS_HELD_FIELD_NUMBER: _ClassVar[int]
    AUTHOR_FIELD_NUMBER: _ClassVar[int]
    CHANGED_BY_FIELD_NUMBER: _ClassVar[int]
    id: str
    revision: int
    kind: str
    title: str
    state: str
    content: str
    wishes: _containers.RepeatedScalarFieldContainer[str]
    keep: bool
    is_over: bool
    is_held: bool
    author: str
    changed_by: str
    def __init__(self, id: _Optional[str] = ..., revision: _Optional[int] = ..., kind: _Optional[str] = ..., title: _Optional[str] = ..., state: _Optional[str] = ..., content: _Optional[str] = ..., wishes: _Optional[_Iterable[str]] = ..., keep: bool = ..., is_over: bool = ..., is_held: bool = ..., author: _Optional[str] = ..., changed_by: _Optional[str] = ...) -> None: ...

class WishWords(_message.Message):
    __slots__ = ("words",)
    WORDS_FIELD_NUMBER: _ClassVar[int]
    words: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, words: _Optional[_Iterable[str]] = ...) -> None: ...

class Wish(_message.Message):
    __slots__ = ("word", "text", "author")
    WORD_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    AUTHOR_FIELD_NUMBER: _ClassVar[int]
    word: str
    text: str
    author: str
    def __init__(self, word: _Optional[str] = ..., text: _Optional[str] = ..., author: _Optional[str] = ...) -> None: ...

class ListRecordsRequest(_message.Message):
    __slots__ = ("ids", "kinds")
    IDS_FIELD_NUMBER: _ClassVar[int]
    KINDS_FIELD_NUMBER: _ClassVar[int]
    ids: _containers.RepeatedScalarFieldContainer[str]
    kinds: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, ids: _Optional[_Iterable[str]] = ..., kinds: _Optional[_Iterable[str]] = ...) -> None: ...

class ListRecordsResponse(_message.Message):
    __slots__ = ("stamp", "records")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    RECORDS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    records: _containers.RepeatedCompositeFieldContainer[Record]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., records: _Optional[_Iterable[_Union[Record, _Mapping]]] = ...) -> None: ...

class WatchRecordsRequest(_message.Message):
    __slots__ = ("kinds",)
    KINDS_FIELD_NUMBER: _ClassVar[int]
    kinds: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, kinds: _Optional[_Iterable[str]] = ...) -> None: ...

class WatchRecordsResponse(_message.Message):
    __slots__ = ("stamp", "records", "removed_ids")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    RECORDS_FIELD_NUMBER: _ClassVar[int]
    REMOVED_IDS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    records: _containers.RepeatedCompositeFieldContainer[Record]
    removed_ids: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., records: _Optional[_Iterable[_Union[Record, _Mapping]]] = ..., removed_ids: _Optional[_Iterable[str]] = ...) -> None: ...

class CreateRecordRequest(_message.Message):
    __slots__ = ("kind", "title", "state", "content", "wishes", "keep", "is_over")
    KIND_FIELD_NUMBER: _ClassVar[int]
    TITLE_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    CONTENT_FIELD_NUMBER: _ClassVar[int]
    WISHES_FIELD_NUMBER: _ClassVar[int]
    KEEP_FIELD_NUMBER: _ClassVar[int]
    IS_OVER_FIELD_NUMBER: _ClassVar[int]
    kind: str
    title: str
    state: str
    content: str
    wishes: WishWords
    keep: bool
    is_over: bool
    def __init__(self, kind: _Optional[str] = ..., title: _Optional[str] = ..., state: _Optional[str] = ..., content: _Optional[str] = ..., wishes: _Optional[_Union[WishWords, _Mapping]] = ..., keep: bool = ..., is_over: bool = ...) -> None: ...

class CreateRecordResponse(_message.Message):
    __slots__ = ("stamp", "record")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    RECORD_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    record: Record
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., record: _Optional[_Union[Record, _Mapping]] = ...) -> None: ...

class UpdateRecordRequest(_message.Message):
    __slots__ = ("id", "expected_revision", "title", "state", "content", "wishes", "keep", "is_over")
    ID_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_REVISION_FIELD_NUMBER: _ClassVar[int]
    TITLE_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    CONTENT_FIELD_NUMBER: _ClassVar[int]
    WISHES_FIELD_NUMBER: _ClassVar[int]
    KEEP_FIELD_NUMBER: _ClassVar[int]
    IS_OVER_FIELD_NUMBER: _ClassVar[int]
    id: str
    expected_revision: int
    title: str
    state: str
    content: str
    wishes: WishWords
    keep: bool
    is_over: bool
    def __init__(self, id: _Optional[str] = ..., expected_revision: _Optional[int] = ..., title: _Optional[str] = ..., state: _Optional[str] = ..., content: _Optional[str] = ..., wishes: _Optional[_Union[WishWords, _Mapping]] = ..., keep: bool = ..., is_over: bool = ...) -> None: ...

class UpdateRecordResponse(_message.Message):
    __slots__ = ("stamp", "record")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    RECORD_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    record: Record
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., record: _Optional[_Union[Record, _Mapping]] = ...) -> None: ...

class HoldRecordRequest(_message.Message):
    __slots__ = ("id",)
    ID_FIELD_NUMBER: _ClassVar[int]
    id: str
    def __init__(self, id: _Optional[str] = ...) -> None: ...

class HoldRecordResponse(_message.Message):
    __slots__ = ("stamp", "wishes")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    WISHES_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    wishes: _containers.RepeatedCompositeFieldContainer[Wish]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., wishes: _Optional[_Iterable[_Union[Wish, _Mapping]]] = ...) -> None: ...

class FileWishRequest(_message.Message):
    __slots__ = ("id", "expected_revision", "word", "text")
    ID_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_REVISION_FIELD_NUMBER: _ClassVar[int]
    WORD_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    id: str
    expected_revision: int
    word: str
    text: str
    def __init__(self, id: _Optional[str] = ..., expected_revision: _Optional[int] = ..., word: _Optional[str] = ..., text: _Optional[str] = ...) -> None: ...

class FileWishResponse(_message.Message):
    __slots__ = ("stamp", "record")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    RECORD_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    record: Record
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., record: _Optional[_Union[Record, _Mapping]] = ...) -> None: ...

class ForgetRecordRequest(_message.Message):
    __slots__ = ("id", "expected_revision")
    ID_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_REVISION_FIELD_NUMBER: _ClassVar[int]
    id: str
    expected_revision: int
    def __init__(self, id: _Optional[str] = ..., expected_revision: _Optional[int] = ...) -> None: ...

class ForgetRecordResponse(_message.Message):
    __slots__ = ("stamp",)
    STAMP_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ...) -> None: ...
