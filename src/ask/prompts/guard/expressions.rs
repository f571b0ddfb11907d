//! Rewrites expressions: each becomes one operand that filters and attributes can follow.

use minijinja::machinery::ast::{
    BinOp, BinOpKind, Call, CallArg, CompareOpKind, Expr, UnaryOpKind,
};

use super::filters::{PAID, SETTLED, TEXT, TIMES};
use super::rewrite::Writer;

impl Writer<'_> {
    /// Writes an expression, in brackets unless it is a name, a literal, or a chain of attributes, calls and filters.
    pub(super) fn expression(&mut self, expr: &Expr<'_>) {
        self.at(expr.span());
        match expr {
            Expr::Var(var) => self.put(var.id),
            Expr::Const(_) => {
                let span = expr.span();
                let source = self.source;
                let literal = source.get(span.start_offset as usize..span.end_offset as usize);
                self.put(literal.unwrap_or("none"));
            }
            Expr::Slice(slice) => {
                self.put("(");
                self.paid(&slice.expr);
                self.put("[");
                self.optional(slice.start.as_ref());
                self.put(":");
                self.optional(slice.stop.as_ref());
                self.put(":");
                self.optional(slice.step.as_ref());
                self.put("]|");
                self.put(SETTLED);
                self.put(")");
            }
            Expr::UnaryOp(unary) => {
                self.put(match unary.op {
                    UnaryOpKind::Not => "(not ",
                    UnaryOpKind::Neg => "(-",
                });
                self.operand(&unary.expr);
                self.put(")");
            }
            Expr::BinOp(binary) => self.binary(binary),
            Expr::Compare(compare) => {
                self.put("(");
                self.paid(&compare.expr);
                for next in &compare.ops {
                    self.put(match next.op {
                        CompareOpKind::Eq => " == ",
                        CompareOpKind::Ne => " != ",
                        CompareOpKind::Lt => " < ",
                        CompareOpKind::Lte => " <= ",
                        CompareOpKind::Gt => " > ",
                        CompareOpKind::Gte => " >= ",
                        CompareOpKind::In => " in ",
                        CompareOpKind::NotIn => " not in ",
                    });
                    self.paid(&next.expr);
                }
                self.put(")");
            }
            Expr::IfExpr(choice) => {
                self.put("(");
                self.expression(&choice.true_expr);
                self.put(" if ");
                self.expression(&choice.test_expr);
                if let Some(other) = &choice.false_expr {
                    self.put(" else ");
                    self.expression(other);
                }
                self.put(")");
            }
            Expr::Filter(filter) => {
                // The first of a filter block has nothing before it.
                if let Some(inner) = &filter.expr {
                    self.expression(inner);
                    self.put("|");
                }
                self.put(filter.name);
                if !filter.args.is_empty() {
                    self.arguments(&filter.args, false);
                }
            }
            Expr::Test(test) => {
                self.put("(");
                self.expression(&test.expr);
                self.put(" is ");
                self.put(test.name);
                if !test.args.is_empty() {
                    self.arguments(&test.args, false);
                }
                self.put(")");
            }
            Expr::GetAttr(attribute) => {
                self.operand(&attribute.expr);
                self.put(".");
                self.put(attribute.name);
            }
            Expr::GetItem(item) => {
                self.operand(&item.expr);
                self.put("[");
                self.paid(&item.subscript_expr);
                self.put("]");
            }
            Expr::Call(call) => self.call(call),
            Expr::List(list) => {
                let literal = self.open(expr);
                self.put("[");
                self.items(&list.items);
                self.put("]");
                self.close(literal);
            }
            Expr::Tuple(tuple) => {
                let literal = self.open(expr);
                self.put("(");
                self.items(&tuple.items);
                self.put(if tuple.items.len() == 1 { ",)" } else { ")" });
                self.close(literal);
            }
            Expr::Map(map) => {
                let literal = self.open(expr);
                self.put("{");
                for (place, (key, value)) in map.keys.iter().zip(&map.values).enumerate() {
                    self.put(if place > 0 { ", " } else { "" });
                    self.expression(key);
                    self.put(": ");
                    self.expression(value);
                }
                // The space keeps two closing braces from ending the tag.
                self.put(" }");
                self.close(literal);
            }
        }
    }

    fn open(&mut self, expr: &Expr<'_>) -> bool {
        let literal = is_literal(expr);
        self.put(if literal { "" } else { "(" });
        literal
    }

    /// Ends a list or map: what is made anew is paid for, and its depth is looked at.
    fn close(&mut self, literal: bool) {
        if !literal {
            self.put("|");
            self.put(PAID);
            self.put(")");
        }
    }

    fn items(&mut self, items: &[Expr<'_>]) {
        for (place, item) in items.iter().enumerate() {
            self.put(if place > 0 { ", " } else { "" });
            self.expression(item);
        }
    }

    fn optional(&mut self, expr: Option<&Expr<'_>>) {
        if let Some(expr) = expr {
            self.expression(expr);
        }
    }

    /// An expression that attributes can follow.
    fn operand(&mut self, expr: &Expr<'_>) {
        let alone = matches!(expr, Expr::Filter(_) | Expr::Const(_));
        self.put(if alone { "(" } else { "" });
        self.expression(expr);
        self.put(if alone { ")" } else { "" });
    }

    /// A call; of objects other than plain functions and macros the arguments are paid for, as these may be compared
    /// or walked.
    pub(super) fn call(&mut self, call: &Call<'_>) {
        self.operand(&call.expr);
        let plain = matches!(&call.expr, Expr::Var(var) if var.id != "loop");
        self.arguments(&call.args, !plain);
    }

    fn arguments(&mut self, arguments: &[CallArg<'_>], paid: bool) {
        self.put("(");
        for (place, argument) in arguments.iter().enumerate() {
            self.put(if place > 0 { ", " } else { "" });
            match argument {
                CallArg::Pos(expr) if paid => self.paid(expr),
                CallArg::Pos(expr) => self.expression(expr),
                CallArg::Kwarg(name, expr) => {
                    self.put(name);
                    self.put("=");
                    self.expression(expr);
                }
                CallArg::PosSplat(expr) => {
                    self.put("*");
                    self.paid(expr);
                }
                CallArg::KwargSplat(expr) => {
                    self.put("**");
                    self.paid(expr);
                }
            }
        }
        self.put(")");
    }

    fn binary(&mut self, binary: &BinOp<'_>) {
        use BinOpKind as Op;
        match binary.op {
            Op::Concat => self.joined(binary, " ~ ", TEXT),
            Op::Add => {
                self.put("(");
                self.joined(binary, " + ", PAID);
                self.put("|");
                self.put(SETTLED);
                self.put(")");
            }
            Op::Mul => {
                self.put("(");
                self.expression(&binary.left);
                self.put("|");
                self.put(TIMES);
                self.put("(");
                self.expression(&binary.right);
                self.put("))");
            }
            Op::ScAnd => self.plain(binary, " and "),
            Op::ScOr => self.plain(binary, " or "),
            Op::Sub => self.plain(binary, " - "),
            Op::Div => self.plain(binary, " / "),
            Op::FloorDiv => self.plain(binary, " // "),
            Op::Rem => self.plain(binary, " % "),
            Op::Pow => self.plain(binary, " ** "),
            Op::Eq => self.compared(binary, " == "),
            Op::Ne => self.compared(binary, " != "),
            Op::Lt => self.compared(binary, " < "),
            Op::Lte => self.compared(binary, " <= "),
            Op::Gt => self.compared(binary, " > "),
            Op::Gte => self.compared(binary, " >= "),
            Op::In => self.compared(binary, " in "),
        }
    }

    /// Numbers and truth: nothing can grow.
    fn plain(&mut self, binary: &BinOp<'_>, sign: &str) {
        self.put("(");
        let parts = parts(binary);
        // From the left, as it was written, without brackets in brackets.
        for (place, part) in parts.iter().enumerate() {
            self.put(if place > 0 { sign } else { "" });
            self.expression(part);
        }
        self.put(")");
    }

    fn compared(&mut self, binary: &BinOp<'_>, sign: &str) {
        self.put("(");
        self.paid(&binary.left);
        self.put(sign);
        self.paid(&binary.right);
        self.put(")");
    }

    /// Texts or lists put together: a part is copied again with each part that follows it.
    fn joined(&mut self, binary: &BinOp<'_>, sign: &str, filter: &str) {
        let parts = parts(binary);
        self.put("(");
        for (place, part) in parts.iter().enumerate() {
            self.put(if place > 0 { sign } else { "" });
            self.expression(part);
            if !matches!(part, Expr::Const(number) if number.value.is_number()) || filter == TEXT {
                let copies = parts.len() - place.max(1);
                self.put(&format!("|{filter}({copies})"));
            }
        }
        self.put(")");
    }
}

/// The operands of a chain of one operator, from the left.
fn parts<'t, 's>(binary: &'t BinOp<'s>) -> Vec<&'t Expr<'s>> {
    let same =
        |other: &BinOpKind| std::mem::discriminant(other) == std::mem::discriminant(&binary.op);
    let mut parts = vec![&binary.right];
    let mut left = &binary.left;
    while let Expr::BinOp(inner) = left
        && same(&inner.op)
        && !compares(&inner.op)
    {
        parts.push(&inner.right);
        left = &inner.left;
    }
    parts.push(left);
    parts.reverse();
    parts
}

fn compares(op: &BinOpKind) -> bool {
    use BinOpKind as Op;
    matches!(
        op,
        Op::Eq | Op::Ne | Op::Lt | Op::Lte | Op::Gt | Op::Gte | Op::In
    )
}

/// Whether an expression is a literal, or a list or map of literals.
pub fn is_literal(expr: &Expr<'_>) -> bool {
    match expr {
        Expr::Const(_) => true,
        Expr::List(list) => list.items.iter().all(is_literal),
        Expr::Tuple(tuple) => tuple.items.iter().all(is_literal),
        Expr::Map(map) => map.keys.iter().chain(&map.values).all(is_literal),
        Expr::UnaryOp(unary) => {
            matches!(unary.op, UnaryOpKind::Neg) && matches!(unary.expr, Expr::Const(_))
        }
        _ => false,
    }
}

/// Whether it is a literal that costs next to nothing: a number, a word.
pub fn is_short(expr: &Expr<'_>) -> bool {
    match expr {
        Expr::Const(literal) => literal.value.as_str().is_none_or(|text| text.len() <= 64),
        Expr::UnaryOp(_) => is_literal(expr),
        _ => false,
    }
}
